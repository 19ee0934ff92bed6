#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <actionlib/client/simple_action_client.h>
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <move_base_msgs/MoveBaseAction.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>
#include <std_msgs/String.h>
#include <support/ros_test.hpp>

#include <frugal_nav/MissionState.h>
#include <frugal_nav/ros/conversions.hpp>

namespace frugal_nav {

using MoveBaseClient = actionlib::SimpleActionClient<move_base_msgs::MoveBaseAction>;

/// Everything around a mission node: the clock, a robot that drives straight to the goal, and a local planner
/// that finds nothing in its way. Each step waits for the node's answer, so that time is simulated.
class MissionGraph {
 public:
  MissionGraph() {
    clock_pub_ = nh_.advertise<rosgraph_msgs::Clock>("/clock", 10);
    odometry_pub_ = nh_.advertise<nav_msgs::Odometry>("odom", 10);
    path_pub_ = nh_.advertise<nav_msgs::Path>("path", 10);
    path_reason_pub_ = nh_.advertise<std_msgs::String>("path/reason", 10);
    local_pub_ = nh_.advertise<LocalCommand>("avoidance/command", 10);
    state_sub_ = nh_.subscribe("mission/state", 100, &MissionGraph::onState, this);
    goal_sub_ = nh_.subscribe("mission/goal", 10, &MissionGraph::onGoal, this);
    command_sub_ = nh_.subscribe("mission/command", 10, &MissionGraph::onCommand, this);
  }

  /// Waits until the node is connected to everything.
  bool connect() {
    return test::waitForSubscriber(odometry_pub_) && test::waitForSubscriber(path_pub_) &&
           test::waitForSubscriber(local_pub_) && test::waitForPublisher(state_sub_) &&
           test::waitForPublisher(goal_sub_) && test::waitForPublisher(command_sub_) && step();
  }

  /// One control period; true when the node has answered with its state.
  bool step() {
    time_ += ros::Duration(0.05);
    rosgraph_msgs::Clock clock;
    clock.clock = time_ - ros::Duration(clock_lag_s);
    clock_pub_.publish(clock);
    move();
    publishPlan();
    const Odometry odometry{toStamp(time_), odom_from_base, twist_, {}, {}};
    if (!publish_odometry) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.005));
      return true;
    }
    odometry_pub_.publish(toRos(odometry, "odom", "base_link"));
    return test::waitUntil([this] { return !states.empty() && states.back().header.stamp == time_; });
  }

  /// Steps until a condition holds; false when it does not within a deadline of wall time: what comes on
  /// other connections takes its own time, however fast the steps are.
  bool stepUntil(const std::function<bool()>& condition, double wall_deadline_s = 30.0) {
    bool answered = true;
    const bool ended = test::waitUntil(
        [&] {
          answered = step();
          return !answered || condition();
        },
        wall_deadline_s);
    return ended && answered;
  }

  ros::Time now() const { return time_; }

  Pose2 odom_from_base;
  bool publish_odometry = true;
  std::string no_path_reason;        ///< why the planner finds no path; empty: it finds one
  double clock_lag_s = 0.0;          ///< of the clock behind the odometry
  std::vector<MissionState> states;  ///< every message on mission/state
  std::optional<Pose2> goal;         ///< the last one on mission/goal
  ros::Time goal_stamp;
  std::size_t goals = 0;  ///< that came on mission/goal

 private:
  void move() {
    twist_ = {};
    if (states.empty()) return;
    const MissionState& state = states.back();
    const bool drives = state.mode == MissionState::MODE_LIDAR || state.mode == MissionState::MODE_CAMERA;
    if (drives && goal && no_path_reason.empty()) {
      odom_from_base.yaw_rad += bearingTo(odom_from_base, goal->position());
      twist_ = {std::min(1.0, 4.0 * distance(odom_from_base, *goal)), 0.0};
    } else if (state.mode == MissionState::MODE_ALIGNING || state.mode == MissionState::MODE_RECOVERING) {
      twist_ = command_;
    }
    odom_from_base = odom_from_base * arcMotion(twist_, 0.05);
  }

  void publishPlan() {
    LocalCommand command;
    command.header.stamp = time_;
    command.header.frame_id = "odom";
    command.status = LocalCommand::STATUS_DRIVING;
    command.holds = LocalCommand::HOLDS_VELOCITY;
    local_pub_.publish(command);
    if (!no_path_reason.empty()) {
      std_msgs::String reason;
      reason.data = no_path_reason;
      path_reason_pub_.publish(reason);
    }
    const bool found = goal && no_path_reason.empty();
    path_pub_.publish(toRos(found ? Path2{odom_from_base, *goal} : Path2{}, toStamp(time_), "odom"));
  }

  void onState(const MissionState& msg) { states.push_back(msg); }
  void onGoal(const geometry_msgs::PoseStamped& msg) {
    goal = planar(msg.pose);
    goal_stamp = msg.header.stamp;
    ++goals;
  }
  void onCommand(const geometry_msgs::TwistStamped& msg) { command_ = planar(msg.twist); }

  ros::NodeHandle nh_;
  ros::Publisher clock_pub_;
  ros::Publisher odometry_pub_;
  ros::Publisher path_pub_;
  ros::Publisher path_reason_pub_;
  ros::Publisher local_pub_;
  ros::Subscriber state_sub_;
  ros::Subscriber goal_sub_;
  ros::Subscriber command_sub_;
  inline static ros::Time time_{100.0};  ///< goes on from test to test
  Twist2 twist_;
  Twist2 command_;
};

/// A goal as clients of move_base write it.
inline move_base_msgs::MoveBaseGoal moveBaseGoal(const Pose2& pose, const std::string& frame = "odom") {
  move_base_msgs::MoveBaseGoal goal;
  goal.target_pose.header.frame_id = frame;
  goal.target_pose.pose = toRos(pose);
  return goal;
}

}  // namespace frugal_nav
