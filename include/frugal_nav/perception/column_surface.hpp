#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/floor_contact.hpp>
#include <frugal_nav/perception/view_rays.hpp>

namespace frugal_nav {

/// What counts as an obstacle, and how the scan is laid out.
struct DepthScanParams {
  double max_height_m = 0.5;
  double min_range_m = 0.15;
  double max_range_m = 5.0;
  double beam_rad = 0.0175;
  double blur_width = 0.03;
  double between_m = 0.25;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("max_height_m", max_height_m,
          Field{"m", "what is higher passes over the robot, which is 0.43 m high", 0.05, 5.0});
    visit("min_range_m", min_range_m, Field{"m", "nearest range, from base_link", 0.01, 5.0});
    visit("max_range_m", max_range_m, Field{"m", "farthest range: the network tells less beyond", 0.5, 50.0});
    visit("beam_rad", beam_rad, Field{"rad", "angle between beams: about a degree", 0.001, 0.2});
    visit("blur_width", blur_width,
          Field{"", "how far the network blurs edges, as a share of the image's width", 0.0, 0.2});
    visit("between_m", between_m,
          Field{"m",
                "a column this much farther than the second on one side and nearer than the second on the "
                "other lies on an edge and tells nothing",
                0.05, 10.0});
  }
  std::string check() const {
    return min_range_m < max_range_m ? "" : "min_range_m must be below max_range_m";
  }
};

/// The nearest surface of one column of the grid that can touch the robot.
struct ColumnSurface {
  enum class State {
    kHit,     ///< a surface
    kFree,    ///< none up to the scan's range
    kUnknown  ///< not known
  };
  State state = State::kUnknown;
  int row = 0;                                       ///< its nearest pixel's
  int top_row = 0;                                   ///< where it ends above
  float depth_m = 0.0F;                              ///< along the optical axis
  float relative_sigma = 0.0F;                       ///< of the depth
  Eigen::Vector2f p_base = Eigen::Vector2f::Zero();  ///< on the floor, in base_link [m]
};

/// Surfaces from the mended inverse depth (CV_32FC1 [1/m]; empty while no scale is known: then the floor
/// lines alone tell), the floor (255) and its lines. `relative_sigma` is CV_32FC1 likewise.
std::vector<ColumnSurface> findSurfaces(const cv::Mat& inverse_depth_pm, const cv::Mat& relative_sigma,
                                        const std::vector<FloorContact>& contacts, const ViewRays& rays,
                                        const DepthScanParams& params);

/// A scan in base_link over the camera's field of view: the nearest surface in each beam, +inf where all is
/// free to max_range_m, NaN where it is not known (REP-117).
LaserScan scanOf(const std::vector<ColumnSurface>& surfaces, const ViewRays& rays, Stamp stamp,
                 const DepthScanParams& params);

/// The scan of an image that told nothing: all NaN. Without a sound camera it has no known width: `rays` null
/// gives one beam ahead.
LaserScan unknownScan(const ViewRays* rays, Stamp stamp, const DepthScanParams& params);

}  // namespace frugal_nav
