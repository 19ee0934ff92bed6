#pragma once

#include <memory>
#include <optional>

#include <nav_msgs/Odometry.h>
#include <opencv2/core/types.hpp>
#include <ros/ros.h>
#include <tf2_ros/transform_broadcaster.h>

#include <frugal_nav/Obstacle.h>
#include <frugal_nav/odometry/visual_cloud.hpp>
#include <frugal_nav/odometry/visual_odometry.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/image_intake.hpp>
#include <frugal_nav/ros/live_parameters.hpp>
#include <frugal_nav/ros/visual_odometry_params.hpp>

namespace frugal_nav {

/// Camera and odom in; vo/odom, vo/points, vo/status, vo/obstacle and the accumulated vo/map out, one of each
/// but the map for every image; the tf of vo/odom on demand. Everything it decides is VisualOdometry's.
///
/// vo/odom and vo/map are where the images say. vo/points are placed by the wheels' pose at the image's
/// stamp, so that whoever takes the robot's pose from odom or tf finds them where the camera saw them.
class VisualOdometryNode {
 public:
  /// Throws ConfigError on bad parameters.
  VisualOdometryNode(ros::NodeHandle nh, ros::NodeHandle pnh);

 private:
  void onObstacle(const Obstacle& msg);
  void process(const CameraFrame& frame);
  void prepare(const CameraFrame& frame);
  std::optional<cv::Rect> region(const CameraFrame& frame) const;
  void publish(const CameraFrame& frame, const VisualOdometryOutput& output);
  void broadcast(const nav_msgs::Odometry& odometry);
  void publishFault(const CameraFrame& frame);
  void publishObstacle(const CameraFrame& frame, const VisualOdometryOutput& output,
                       const std::optional<cv::Rect>& region);
  void publishMap(Stamp stamp);
  void report(const VisualStatus& status);
  void forget();

  VisualOdometryNodeParams params_;
  NodeDiagnostics diagnostics_;
  std::optional<VisualOdometry> odometry_;  // from the first sound image on
  Pinhole camera_;                          // its calibration
  std::optional<VisualOdometryOutput> last_;
  VisualCloud cloud_;
  std::optional<Obstacle> nearest_;
  ros::Time last_map_;

  std::unique_ptr<ImageIntake> intake_;
  ros::Publisher odom_pub_;
  ros::Publisher points_pub_;
  ros::Publisher status_pub_;
  ros::Publisher obstacle_pub_;
  ros::Publisher map_pub_;
  tf2_ros::TransformBroadcaster broadcaster_;
  ros::Subscriber nearest_sub_;
  std::unique_ptr<LiveParameterServer> live_;
};

}  // namespace frugal_nav
