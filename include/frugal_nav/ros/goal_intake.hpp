#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <geometry_msgs/PoseStamped.h>
#include <ros/ros.h>

#include <frugal_nav/MissionState.h>
#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/mission_status.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/time_jump_watch.hpp>

namespace frugal_nav {

/// Where the mission drives to: mission/goal, as long as mission/state says that it is underway. The two come
/// on different connections, in either order.
class GoalIntake {
 public:
  GoalIntake(ros::NodeHandle nh, std::string odom_frame, Mode drive_mode, NodeDiagnostics& diagnostics,
             TimeJumpWatch& time);
  GoalIntake(const GoalIntake&) = delete;  // subscriptions hold its address
  GoalIntake& operator=(const GoalIntake&) = delete;

  /// The goal in odom while the mission drives there in its mode, or is at something of its own on the way:
  /// it wants to know whether the way is free again. Otherwise nothing.
  std::optional<Pose2> goal() const;
  /// The mission's number of that goal.
  std::uint32_t number() const { return mission_.goal_number; }
  /// After a jump back in time, to `now`: stands until the mission speaks again.
  void forget(Stamp now);

 private:
  void onGoal(const geometry_msgs::PoseStamped& msg);
  void onState(const MissionState& msg);

  std::string odom_frame_;
  Mode drive_mode_;
  NodeDiagnostics& diagnostics_;
  TimeJumpWatch& time_;
  MissionStatus mission_;
  std::optional<Pose2> goal_;
  Stamp goal_stamp_{};
  Stamp number_before_{};  ///< of the last state with another goal's number
  ros::Subscriber goal_sub_;
  ros::Subscriber state_sub_;
};

}  // namespace frugal_nav
