#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <frugal_nav/eval/visual_drive.hpp>
#include <frugal_nav/odometry/visual_odometry.hpp>
#include <frugal_nav/perception/depth_gap.hpp>

namespace frugal_nav::eval {

/// A depth network that answers several times for one image and runs once.
class SharedDepthNetwork {
 public:
  explicit SharedDepthNetwork(std::unique_ptr<DepthNetwork> network);

  /// Makes the next answers those for this image.
  void show(const cv::Mat& bgr);
  /// A network that gives the present answer, to be handed to a DepthGap; it must not outlive this.
  std::unique_ptr<DepthNetwork> answer() const;

 private:
  std::unique_ptr<DepthNetwork> network_;
  std::shared_ptr<DepthPrediction> prediction_;
};

/// Where an obstacle is seen in the image it was found in.
std::optional<cv::Rect> regionOf(const NearestObstacle& obstacle);

/// Points of an output as DepthGap takes them: seen from the wheels' pose.
std::vector<MetricPoint> metricPoints(const VisualOdometryOutput& output,
                                      const Eigen::Isometry3d& base_from_optical,
                                      const Pose2& odom_from_base);

}  // namespace frugal_nav::eval
