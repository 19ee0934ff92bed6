#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include <frugal_nav/common/gap_sighting.hpp>
#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/nearest_obstacle.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/perception/column_profile.hpp>
#include <frugal_nav/perception/column_surface.hpp>
#include <frugal_nav/perception/contact_memory.hpp>
#include <frugal_nav/perception/depth_correction.hpp>
#include <frugal_nav/perception/depth_network.hpp>
#include <frugal_nav/perception/floor_contact.hpp>
#include <frugal_nav/perception/floor_mask.hpp>
#include <frugal_nav/perception/gap_finder.hpp>
#include <frugal_nav/perception/metric_fit.hpp>
#include <frugal_nav/perception/obstacle_motion.hpp>
#include <frugal_nav/perception/view_rays.hpp>

namespace frugal_nav {

/// A point of visual odometry.
struct MetricPoint {
  cv::Point2f pixel;                                 ///< in the image as given
  Eigen::Vector3d p_odom = Eigen::Vector3d::Zero();  ///< [m]
  double sigma_m = 0.0;                              ///< standard deviation of its depth
};

/// The person who is the goal: no obstacle, and a metric cue while it is seen.
struct KnownGoal {
  Eigen::Vector2d p_odom = Eigen::Vector2d::Zero();         ///< [m]
  Eigen::Matrix2d covariance_m2 = Eigen::Matrix2d::Zero();  ///< of p_odom
  double above_floor_m = 0.0;                               ///< of the head's centre
  bool seen = false;                                        ///< in this image
  cv::Rect2d box_px;  ///< of the head; empty: where its place lies in the image
};

/// One image and what it was taken with.
struct DepthView {
  Stamp stamp{};
  cv::Mat bgr;     ///< CV_8UC3
  Pinhole camera;  ///< of this image, or of the one it was resized from
  Eigen::Isometry3d base_from_optical = Eigen::Isometry3d::Identity();
  Pose2 odom_from_base;             ///< at the stamp
  std::vector<MetricPoint> points;  ///< of this image; empty without visual odometry
  std::optional<KnownGoal> goal;
};

/// Parameters of depth, gap and nearest obstacle.
struct DepthGapParams {
  std::string method = "fused";
  double unscaled_factor_pm = 1.0;
  int grid_width_px = 160;
  double vo_scale_sigma = 0.02;
  double min_goal_sigma = 0.05;
  bool use_network_floor = true;
  FloorMaskParams floor;
  FloorContactParams contact;
  ContactMemoryParams memory;
  MetricFitParams fit;
  DepthCorrectionParams correction;
  DepthScanParams scan;
  GapFinderParams gap;
  ObstacleMotionParams obstacle;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("method", method,
          Field{"",
                "what gives the metres: fused (visual odometry, floor and goal), vo (the paper's: visual "
                "odometry alone), unscaled (one factor for all images)",
                -1, 1, "fused|vo|unscaled"});
    visit("unscaled_factor_pm", unscaled_factor_pm,
          Field{"1/m", "unscaled: 1 / depth is this times the network's value", 1e-9, 1e9});
    visit("grid_width_px", grid_width_px,
          Field{"px", "width of the grid on which all but the network works", 40, 640});
    visit("vo_scale_sigma", vo_scale_sigma,
          Field{"", "error of visual odometry's scale as a share of it: that of the wheels", 0.0, 1.0});
    visit("min_goal_sigma", min_goal_sigma,
          Field{"", "least error of the goal's distance as a share of it: heads differ", 0.0, 1.0});
    visit("use_network_floor", use_network_floor,
          Field{"",
                "whether a network that tells the floor is believed; false: the colour, as for all others"});
    visit("floor", floor);
    visit("contact", contact);
    visit("memory", memory);
    visit("fit", fit);
    visit("correction", correction);
    visit("scan", scan);
    visit("gap", gap);
    visit("obstacle", obstacle);
  }
};

/// What one image told. Matrices have the size of the working grid, which covers the whole image.
struct DepthFrame {
  Stamp stamp{};
  std::string fault;  ///< why the image could not be used; empty when it was
  cv::Mat inverse;    ///< CV_32FC1, relative inverse depth, near is large
  cv::Mat depth_m;    ///< CV_32FC1, along the optical axis; NaN unknown; empty until the scale is known
  cv::Mat floor;      ///< CV_8UC1, 255 floor
  MetricFit fit;
  ColumnProfile profile;
  std::vector<char> near;  ///< one a column of the grid: 0 open, 1 near
  std::vector<FloorContact> contacts;
  std::vector<ColumnSurface> surfaces;
  LaserScan scan;  ///< in base_link
  GapSighting gap;
  NearestObstacle obstacle;
};

/// Depth from one image, metric as soon as anything tells metres; the gap to drive through and the nearest
/// obstacle in it (paper 000, stages 6 to 8).
class DepthGap {
 public:
  /// Throws ConfigError on parameters out of range.
  DepthGap(std::unique_ptr<DepthNetwork> network, const DepthGapParams& params);
  ~DepthGap();
  DepthGap(DepthGap&&) noexcept;
  DepthGap& operator=(DepthGap&&) noexcept;

  /// Takes one image. One that cannot be used gives its fault, a scan of NaN and neither gap nor obstacle. A
  /// stamp before the last one forgets everything first.
  DepthFrame look(const DepthView& view);

  /// Other parameters from the next image on; all is forgotten. Throws ConfigError on ones out of range.
  void setParams(const DepthGapParams& params);

  /// Forgets scale, floor colour and obstacles.
  void reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace frugal_nav
