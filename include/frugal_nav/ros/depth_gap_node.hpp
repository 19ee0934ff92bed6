#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>

#include <frugal_nav/perception/depth_gap.hpp>
#include <frugal_nav/ros/depth_gap_params.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/image_intake.hpp>
#include <frugal_nav/ros/live_parameters.hpp>

namespace frugal_nav {

/// Camera, odom, vo/points and goal/observed in; gap, obstacle/nearest and depth/scan out for every image,
/// depth/inverse for every one that could be used, depth/image once the scale is known, depth/debug_image for
/// who looks. Everything it decides is DepthGap's.
class DepthGapNode {
 public:
  /// Throws ConfigError on bad parameters, and when the model is missing or broken.
  DepthGapNode(ros::NodeHandle nh, ros::NodeHandle pnh);

 private:
  void onPoints(const sensor_msgs::PointCloud2& msg);
  void onGoal(const geometry_msgs::PoseWithCovarianceStamped& msg);
  bool hasPoints(const CameraFrame& frame) const;
  void process(const CameraFrame& frame);
  DepthView viewOf(const CameraFrame& frame);
  std::optional<KnownGoal> goalAt(Stamp stamp) const;
  void publish(const CameraFrame& frame, const DepthFrame& depth);
  void report(const DepthFrame& depth);
  void forget();

  DepthGapNodeParams params_;
  NodeDiagnostics diagnostics_;
  DepthGap depth_gap_;
  std::unique_ptr<ImageIntake> intake_;
  struct Points {
    Stamp stamp{};
    std::vector<MetricPoint> points;
  };
  std::optional<Points> points_;
  struct Goal {
    Stamp stamp{};
    KnownGoal goal;
  };
  std::optional<Goal> goal_;
  ros::Subscriber points_sub_;
  ros::Subscriber goal_sub_;
  ros::Publisher inverse_pub_;
  ros::Publisher depth_pub_;
  ros::Publisher gap_pub_;
  ros::Publisher obstacle_pub_;
  ros::Publisher scan_pub_;
  ros::Publisher debug_pub_;
  std::unique_ptr<LiveParameterServer> live_;
};

}  // namespace frugal_nav
