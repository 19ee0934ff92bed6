#pragma once

#include <memory>
#include <string>

#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <tf2_ros/transform_broadcaster.h>

#include <frugal_nav/WheelTicks.h>
#include <frugal_nav/odometry/wheel_odometry.hpp>
#include <frugal_nav/robot/robot_model.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/live_parameters.hpp>
#include <frugal_nav/ros/silence_watch.hpp>
#include <frugal_nav/ros/wheel_odometry_params.hpp>

namespace frugal_nav {

/// wheel_ticks or joint_states in; odom and tf out, and joint_states when fed by ticks. One odom for each
/// reading.
class WheelOdometryNode {
 public:
  /// Throws ConfigError on bad parameters or a missing robot_description.
  WheelOdometryNode(ros::NodeHandle nh, ros::NodeHandle pnh);

 private:
  void watchSilence();
  void onTicks(const WheelTicks& msg);
  void onJointStates(const sensor_msgs::JointState& msg);
  void publish(const Odometry& odometry);
  void publishJoints(const Odometry& odometry);
  void report(const std::string& input);

  WheelOdometryNodeParams params_;
  RobotModel robot_;
  WheelOdometry odometry_;
  NodeDiagnostics diagnostics_;
  std::unique_ptr<LiveParameterServer> tuning_;
  WheelOdometryCounts reported_;
  tf2_ros::TransformBroadcaster broadcaster_;
  ros::Publisher odom_pub_;
  ros::Publisher joints_pub_;
  ros::Subscriber wheels_sub_;
  SilenceWatch silence_;
  ros::Timer timer_;
};

}  // namespace frugal_nav
