#pragma once

#include <memory>

#include <nav_msgs/Path.h>
#include <ros/ros.h>

#include <frugal_nav/planning/lidar_avoidance.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/live_parameters.hpp>
#include <frugal_nav/ros/planning_params.hpp>
#include <frugal_nav/ros/scan_intake.hpp>

namespace frugal_nav {

/// Turns scan, path and mission/goal into avoidance/command, one a scan, and shows the sectors on
/// avoidance/markers to who listens. Everything it decides is LidarAvoidance's.
class LidarAvoidanceNode {
 public:
  LidarAvoidanceNode(ros::NodeHandle nh, ros::NodeHandle pnh);

 private:
  void onPath(const nav_msgs::Path& msg);
  bool hasPathFor(const PosedScan& posed);
  void process(const PosedScan& posed);
  void report(const MotionCommand& command);

  LidarAvoidanceNodeParams params_;
  BodyExtent body_;
  LidarAvoidance avoidance_;
  NodeDiagnostics diagnostics_;
  ros::Publisher command_pub_;
  ros::Publisher markers_pub_;
  ros::Subscriber path_sub_;
  std::unique_ptr<ScanIntake> intake_;
  std::unique_ptr<LiveParameterServer> live_;
};

}  // namespace frugal_nav
