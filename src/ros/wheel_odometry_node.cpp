#include <algorithm>

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/parameters.hpp>
#include <frugal_nav/ros/wheel_odometry_node.hpp>

namespace frugal_nav {
namespace {

constexpr double kSilentAfter_s = 2.0;

WheelOdometryNodeParams loadParams(const ros::NodeHandle& pnh) {
  WheelOdometryNodeParams params;
  loadParameters(pnh, params);
  return params;
}

/// Place of a joint in a message; -1 when the message is about others.
std::ptrdiff_t indexOf(const sensor_msgs::JointState& msg, const std::string& joint) {
  const auto found = std::find(msg.name.begin(), msg.name.end(), joint);
  return found == msg.name.end() ? -1 : found - msg.name.begin();
}

}  // namespace

WheelOdometryNode::WheelOdometryNode(ros::NodeHandle nh, ros::NodeHandle pnh)
    : params_(loadParams(pnh)),
      robot_(loadRobotDescription(pnh, params_.base_frame)),
      odometry_(params_.odometry, {robot_.drive.radius_m, robot_.drive.separation_m}),
      diagnostics_(nh, pnh) {
  odom_pub_ = nh.advertise<nav_msgs::Odometry>("odom", 50);
  // Small messages in a control loop: Nagle's algorithm would hold them back for tens of milliseconds.
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  if (params_.source == "ticks") {
    joints_pub_ = nh.advertise<sensor_msgs::JointState>("joint_states", 50);
    wheels_sub_ = nh.subscribe("wheel_ticks", 50, &WheelOdometryNode::onTicks, this, hints);
    diagnostics_.input("wheel_ticks");
  } else {
    wheels_sub_ = nh.subscribe("joint_states", 50, &WheelOdometryNode::onJointStates, this, hints);
    diagnostics_.input("joint_states");
  }
  timer_ = nh.createTimer(ros::Duration(1.0), [this](const ros::TimerEvent&) { watchSilence(); });
  tuning_ = tuneLive<WheelOdometryNodeParams>(
      pnh, params_, [this](const WheelOdometryNodeParams& params) { odometry_.setParams(params.odometry); });
}

void WheelOdometryNode::watchSilence() {
  if (!silence_.isSilent(ros::Time::now(), kSilentAfter_s)) return;
  std::string silence = "no message on " + wheels_sub_.getTopic();
  if (params_.source != "ticks")
    silence += " with the URDF's wheels " + robot_.drive.left_joint + " and " + robot_.drive.right_joint;
  silence += ": is the base's driver running?";
  diagnostics_.status(diagnostic_msgs::DiagnosticStatus::WARN, silence);
  ROS_WARN_THROTTLE(10.0, "%s", silence.c_str());
}

void WheelOdometryNode::onTicks(const WheelTicks& msg) {
  silence_.heard(ros::Time::now());
  if (msg.header.stamp.isZero()) {
    diagnostics_.input("wheel_ticks").refused("no stamp");
    return;
  }
  const Stamp stamp = toStamp(msg.header.stamp);
  const std::optional<Odometry> odometry = odometry_.addTicks(stamp, msg.left, msg.right);
  if (odometry) {
    diagnostics_.input("wheel_ticks").received(stamp, toStamp(ros::Time::now()));
    publish(*odometry);
    publishJoints(*odometry);
  }
  report("wheel_ticks");
}

void WheelOdometryNode::onJointStates(const sensor_msgs::JointState& msg) {
  const std::ptrdiff_t left = indexOf(msg, robot_.drive.left_joint);
  const std::ptrdiff_t right = indexOf(msg, robot_.drive.right_joint);
  if (left < 0 || right < 0) return;  // other joints have publishers of their own
  silence_.heard(ros::Time::now());
  if (msg.header.stamp.isZero() || msg.position.size() != msg.name.size()) {
    diagnostics_.input("joint_states").refused("no stamp, or not a position for each joint");
    return;
  }
  const Stamp stamp = toStamp(msg.header.stamp);
  const auto angle = [&msg](std::ptrdiff_t joint) { return msg.position[static_cast<std::size_t>(joint)]; };
  const std::optional<Odometry> odometry = odometry_.addAngles(stamp, angle(left), angle(right));
  if (odometry) {
    diagnostics_.input("joint_states").received(stamp, toStamp(ros::Time::now()));
    publish(*odometry);
  }
  report("joint_states");
}

void WheelOdometryNode::publish(const Odometry& odometry) {
  odom_pub_.publish(toRos(odometry, params_.odom_frame, params_.base_frame));
  if (!params_.publish_tf) return;
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = toRos(odometry.stamp);
  transform.header.frame_id = params_.odom_frame;
  transform.child_frame_id = params_.base_frame;
  const geometry_msgs::Pose pose = toRos(odometry.odom_from_base);
  transform.transform.translation.x = pose.position.x;
  transform.transform.translation.y = pose.position.y;
  transform.transform.rotation = pose.orientation;
  broadcaster_.sendTransform(transform);
}

void WheelOdometryNode::publishJoints(const Odometry& odometry) {
  const double half = 0.5 * robot_.drive.separation_m * odometry.twist.w_radps;
  sensor_msgs::JointState joints;
  joints.header.stamp = toRos(odometry.stamp);
  joints.name = {robot_.drive.left_joint, robot_.drive.right_joint};
  joints.position = {odometry_.leftAngle_rad(), odometry_.rightAngle_rad()};
  joints.velocity = {(odometry.twist.v_mps - half) / robot_.drive.radius_m,
                     (odometry.twist.v_mps + half) / robot_.drive.radius_m};
  joints_pub_.publish(joints);
}

void WheelOdometryNode::report(const std::string& input) {
  const WheelOdometryCounts& counts = odometry_.counts();
  if (counts.restarts > reported_.restarts) {
    ROS_WARN("time jumped back: the odometry starts at its starting pose again");
  }
  if (counts.rebased > reported_.rebased) {
    ROS_WARN("the wheels jumped farther than they can turn: taken as a restarted counter, the pose stays");
    diagnostics_.input(input).dropped("implausible jump of the wheels");
  }
  if (counts.duplicates > reported_.duplicates) diagnostics_.input(input).dropped("the stamp came twice");
  if (counts.refused > reported_.refused) diagnostics_.input(input).refused("not finite");
  reported_ = counts;
  diagnostics_.set("restarts by time jumps", static_cast<double>(counts.restarts));
}

}  // namespace frugal_nav
