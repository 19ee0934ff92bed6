#pragma once

#include <memory>
#include <optional>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/ros.h>

#include <frugal_nav/planning/camera_planner.hpp>
#include <frugal_nav/ros/camera_intake.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/goal_intake.hpp>
#include <frugal_nav/ros/live_parameters.hpp>
#include <frugal_nav/ros/path_reason.hpp>
#include <frugal_nav/ros/planning_params.hpp>
#include <frugal_nav/ros/time_jump_watch.hpp>

namespace frugal_nav {

/// The planner in mode camera: turns mission/goal, gap, obstacle/nearest and depth/scan into path, one for
/// each image, and shows grid and planner/markers to who listens. Everything it decides is CameraPlanner's.
class CameraPlannerNode {
 public:
  CameraPlannerNode(ros::NodeHandle nh, ros::NodeHandle pnh);
  CameraPlannerNode(const CameraPlannerNode&) = delete;  // callbacks hold its address
  CameraPlannerNode& operator=(const CameraPlannerNode&) = delete;

 private:
  void onObserved(const geometry_msgs::PoseWithCovarianceStamped& msg);
  void process(const CameraObservation& observation);
  void forget(Stamp now);
  std::optional<Eigen::Vector2d> personAt(const std::optional<Pose2>& odom_from_goal, Stamp now) const;
  void report(const CameraPlan& plan);
  void show(const CameraPlan& plan);

  CameraPlannerNodeParams params_;
  CameraPlanner planner_;
  NodeDiagnostics diagnostics_;
  PathReason reason_;
  TimeJumpWatch time_;
  GoalIntake goal_;
  std::optional<Eigen::Vector2d> p_odom_person_;
  Stamp person_seen_{};
  ros::Time last_grid_;
  ros::Publisher path_pub_;
  ros::Publisher grid_pub_;
  ros::Publisher markers_pub_;
  ros::Subscriber observed_sub_;
  std::unique_ptr<CameraIntake> intake_;
  ros::Timer timer_;
  std::unique_ptr<LiveParameterServer> live_;
};

}  // namespace frugal_nav
