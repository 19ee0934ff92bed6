#pragma once

#include <memory>
#include <optional>

#include <ros/ros.h>

#include <frugal_nav/perception/goal_finder.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/goal_detector_params.hpp>
#include <frugal_nav/ros/image_intake.hpp>
#include <frugal_nav/ros/live_parameters.hpp>

namespace frugal_nav {

/// Camera and odom in; goal/detections out for every image, goal/observed when the goal was seen in it, and
/// goal/debug_image for who looks. Everything it decides is GoalFinder's.
class GoalDetectorNode {
 public:
  /// Throws ConfigError on bad parameters, and when the model is missing or broken.
  GoalDetectorNode(ros::NodeHandle nh, ros::NodeHandle pnh);

 private:
  void process(const CameraFrame& frame);
  void publish(const CameraFrame& frame, const GoalFrame& goal);
  void publishDebugImage(const CameraFrame& frame, const GoalFrame& goal);
  void report(const GoalFrame& goal);

  GoalDetectorNodeParams params_;
  NodeDiagnostics diagnostics_;
  GoalFinder finder_;
  std::unique_ptr<ImageIntake> intake_;
  ros::Publisher detections_pub_;
  ros::Publisher observed_pub_;
  ros::Publisher debug_pub_;
  ros::Subscriber surfaces_sub_;
  std::unique_ptr<LiveParameterServer> live_;
};

}  // namespace frugal_nav
