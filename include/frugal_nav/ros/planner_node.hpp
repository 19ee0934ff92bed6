#pragma once

#include <memory>

#include <ros/ros.h>

#include <frugal_nav/planning/lidar_planner.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/live_parameters.hpp>
#include <frugal_nav/ros/path_reason.hpp>
#include <frugal_nav/ros/planning_params.hpp>
#include <frugal_nav/ros/scan_intake.hpp>

namespace frugal_nav {

/// Turns mission/goal and scan into path, and shows grid and planner/markers to who listens. Everything it
/// decides is LidarPlanner's.
class PlannerNode {
 public:
  PlannerNode(ros::NodeHandle nh, ros::NodeHandle pnh);

 private:
  void process(const PosedScan& posed);
  void report(const LidarPlan& plan);
  void publishGrid(ros::Time stamp);

  PlannerNodeParams params_;
  BodyExtent body_;
  LidarPlanner planner_;
  NodeDiagnostics diagnostics_;
  PathReason reason_;
  ros::Publisher path_pub_;
  ros::Publisher grid_pub_;
  ros::Publisher markers_pub_;
  ros::Time last_grid_;
  std::unique_ptr<ScanIntake> intake_;
  std::unique_ptr<LiveParameterServer> live_;
};

}  // namespace frugal_nav
