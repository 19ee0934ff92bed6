#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/perception/marker_detector.hpp>
#include <frugal_nav/perception/marker_map.hpp>

namespace frugal_nav::eval {

/// The constants of the paper's filter, which it does not name: those with which it errs least in halls of
/// tuning seeds.
struct AsPrintedParams {
  double process_sigma_m = 0.005;
  double process_sigma_rad = 0.02;
  double marker_sigma_m = 0.3;
  double marker_sigma_rad = 0.1;
  double max_image_error_px = 2.0;
  double max_range_m = 3.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("process_sigma_m", process_sigma_m, Field{"m", "added to x and y at each prediction", 0.0, 1.0});
    visit("process_sigma_rad", process_sigma_rad,
          Field{"rad", "added to the heading at each prediction", 0.0, 1.0});
    visit("marker_sigma_m", marker_sigma_m, Field{"m", "of a marker's x and y", 1e-4, 10.0});
    visit("marker_sigma_rad", marker_sigma_rad, Field{"rad", "of a marker's heading", 1e-4, 10.0});
    visit("max_image_error_px", max_image_error_px,
          Field{"px", "mean reprojection error past which a marker is discarded", 0.1, 50.0});
    visit("max_range_m", max_range_m, Field{"m", "farther markers are of an unrealistic size", 0.1, 50.0});
  }
};

/// The markers of an image as the paper finds them: OpenCV's detector as it comes, which puts corners on
/// whole pixels.
std::vector<MarkerCorners> detectAsPrinted(const cv::Mat& image, const std::string& dictionary);

/// The localization filter as paper 001 prints it (section 4.2), to compare with: commanded speed, heading
/// overwritten by the IMU's at each step, one marker an image (the largest) by solvePnP, constant
/// covariances, measurements applied when they come. The map of markers, which the paper leaves out, and the
/// true pose to start from are given to it.
class AsPrintedFilter {
 public:
  /// Throws ConfigError on parameters out of range.
  AsPrintedFilter(const AsPrintedParams& params, MarkerMap map, const Pinhole& camera,
                  const Eigen::Isometry3d& base_from_optical, const Pose2& map_from_base);

  /// Integrates the IMU's heading.
  void addGyro(Stamp stamp, double rate_radps);
  /// Predicts with the speed that was commanded until now.
  void predict(Stamp stamp, double commanded_mps);
  /// Corrects by the largest marker, if it is sound.
  void correct(const std::vector<MarkerCorners>& markers);

  const Pose2& mapFromBase() const { return map_from_base_; }

 private:
  std::optional<Pose2> measure(const MarkerCorners& corners) const;

  AsPrintedParams params_;
  MarkerMap map_;
  Pinhole camera_;
  Eigen::Isometry3d base_from_optical_;
  Pose2 map_from_base_;
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
  double imu_yaw_rad_;
  std::optional<Stamp> last_gyro_;
  std::optional<Stamp> last_prediction_;
};

}  // namespace frugal_nav::eval
