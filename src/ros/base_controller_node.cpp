#include <algorithm>

#include <geometry_msgs/Twist.h>

#include <frugal_nav/ros/base_controller_node.hpp>
#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/node_main.hpp>
#include <frugal_nav/ros/parameters.hpp>
#include <frugal_nav/ros/planning_markers.hpp>

namespace frugal_nav {
namespace {

BaseControllerNodeParams loadParams(const ros::NodeHandle& pnh) {
  BaseControllerNodeParams params;
  loadParameters(pnh, params);
  return params;
}

BaseGeometry loadGeometry(const ros::NodeHandle& pnh, const std::string& base_frame) {
  const RobotModel robot = loadRobotDescription(pnh, base_frame);
  return {robot.footprint, robot.drive.separation_m};
}

// Simulated time comes in messages of its own, which TCP gathers for 40 ms. A simulator that runs faster than
// real time, or catches up after a wait for a command, is so far ahead of its clock by some tenths of a
// second.
constexpr double kClockLag_s = 1.0;

BaseControlParams forClock(BaseControlParams params) {
  if (ros::Time::isSimTime()) params.future_tolerance_s = std::max(params.future_tolerance_s, kClockLag_s);
  return params;
}

const char* nameOf(BaseCommand::Source source) {
  static constexpr const char* kNames[] = {"none", "avoidance/command", "path", "mission/command",
                                           "cmd_vel_in"};
  return kNames[static_cast<int>(source)];
}

bool isFault(BaseCommand::Reason reason) {
  return reason != BaseCommand::Reason::kNone && reason != BaseCommand::Reason::kIdle;
}

}  // namespace

BaseControllerNode::BaseControllerNode(ros::NodeHandle nh, ros::NodeHandle pnh)
    : params_(loadParams(pnh)),
      control_(forClock(params_.control), loadGeometry(pnh, params_.base_frame)),
      diagnostics_(nh, pnh),
      sensors_(params_.base_frame) {
  cmd_vel_pub_ = nh.advertise<geometry_msgs::Twist>("cmd_vel", 10);
  cmd_vel_stamped_pub_ = nh.advertise<geometry_msgs::TwistStamped>("cmd_vel_stamped", 10);
  markers_pub_ = nh.advertise<visualization_msgs::MarkerArray>("base_controller/markers", 5);
  // Small messages in a control loop: Nagle's algorithm would hold them back for tens of milliseconds.
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  using Node = BaseControllerNode;
  subscribers_ = {nh.subscribe("mission/state", 10, &Node::onMissionState, this, hints),
                  nh.subscribe("odom", 10, &Node::onOdometry, this, hints),
                  nh.subscribe("scan", 2, &Node::onScan, this, hints),
                  nh.subscribe("avoidance/command", 2, &Node::onLocalCommand, this, hints),
                  nh.subscribe("path", 2, &Node::onPath, this, hints),
                  nh.subscribe("obstacle/nearest", 2, &Node::onObstacle, this, hints),
                  nh.subscribe("depth/scan", 2, &Node::onDepthScan, this, hints),
                  nh.subscribe("mission/command", 10, &Node::onMissionCommand, this, hints),
                  nh.subscribe("cmd_vel_in", 10, &Node::onManualCommand, this, hints)};
  for (const char* topic : {"mission/state", "odom", "scan", "avoidance/command", "path", "obstacle/nearest",
                            "depth/scan", "mission/command", "cmd_vel_in"}) {
    diagnostics_.input(topic);
  }
  timer_ =
      nh.createTimer(ros::Duration(1.0 / params_.rate_hz), [this](const ros::TimerEvent&) { onTimer(); });
  tuning_ = tuneLive<BaseControllerNodeParams>(pnh, params_, [this](const BaseControllerNodeParams& params) {
    control_.setParams(forClock(params.control));
  });
}

BaseControllerNode::~BaseControllerNode() { stop(); }

void BaseControllerNode::stop() {
  if (stopped_) return;
  timer_.stop();
  subscribers_.clear();
  publish({}, stamp_);
  stopped_ = true;
}

void BaseControllerNode::onMissionState(const MissionState& msg) {
  const Stamp stamp = toStamp(msg.header.stamp);
  Pending pending{stamp, stamp, Stamp{}, Stamp{}, Stamp{}};
  if (const std::optional<MissionStatus> status = fromRos(msg)) {
    note("mission/state", control_.setMission(*status), stamp);
    if (status->mode == Mode::kAligning || status->mode == Mode::kRecovering) pending.mission_command = stamp;
  } else {
    control_.refuse("mission/state", "unknown mode or state");
    note("mission/state", false, stamp);
  }
  request(pending);
}

void BaseControllerNode::onOdometry(const nav_msgs::Odometry& msg) {
  odom_stamp_ = toStamp(msg.header.stamp);
  if (msg.header.frame_id != params_.odom_frame) {
    control_.refuse("odom",
                    "it is in \"" + msg.header.frame_id + "\", not in \"" + params_.odom_frame + "\"");
    note("odom", false, odom_stamp_);
  } else if (const std::optional<Odometry> odometry = fromRos(msg)) {
    note("odom", control_.setOdometry(*odometry), odom_stamp_);
  } else {
    control_.refuse("odom", "not finite, or no sound quaternion");
    note("odom", false, odom_stamp_);
  }
  cycleWhenReady();
}

void BaseControllerNode::onScan(const sensor_msgs::LaserScan& msg) {
  scan_stamp_ = toStamp(msg.header.stamp);
  const std::variant<Pose2, std::string> laser = sensors_.laser(msg.header.frame_id);
  if (const auto fault = findAngleFault(msg)) {
    control_.refuse("scan", *fault);
    note("scan", false, scan_stamp_);
  } else if (const auto* base_from_laser = std::get_if<Pose2>(&laser)) {
    note("scan", control_.setScan(fromRos(msg), *base_from_laser), scan_stamp_);
  } else {
    control_.refuse("scan", std::get<std::string>(laser));
    note("scan", false, scan_stamp_);
  }
  cycleWhenReady();
}

void BaseControllerNode::onLocalCommand(const LocalCommand& msg) {
  const Stamp stamp = toStamp(msg.header.stamp);
  if (msg.holds == LocalCommand::HOLDS_TARGET && msg.header.frame_id != params_.odom_frame) {
    control_.refuse("avoidance/command", "its target is in \"" + msg.header.frame_id + "\", not in \"" +
                                             params_.odom_frame + "\"");
    note("avoidance/command", false, stamp);
  } else if (const std::optional<MotionCommand> command = fromRos(msg)) {
    note("avoidance/command", control_.setLocalCommand(*command), stamp);
  } else {
    control_.refuse("avoidance/command", "unknown status, or not finite");
    note("avoidance/command", false, stamp);
  }
  request({stamp, stamp, stamp, Stamp{}, Stamp{}});
}

void BaseControllerNode::onPath(const nav_msgs::Path& msg) {
  const Stamp stamp = toStamp(msg.header.stamp);
  const std::optional<Path2> path = fromRos(msg);
  if (!msg.poses.empty() && msg.header.frame_id != params_.odom_frame) {
    control_.refuse("path",
                    "it is in \"" + msg.header.frame_id + "\", not in \"" + params_.odom_frame + "\"");
    note("path", false, stamp);
  } else if (path) {
    note("path", control_.setPath(*path, stamp), stamp);
  } else {
    control_.refuse("path", "not finite, or no sound quaternion");
    note("path", false, stamp);
  }
  // Where a camera leads, each image gets its command, also while the mission itself turns the robot.
  const Mode mode = control_.mode();
  const bool has_camera = obstacle_stamp_ != Stamp{} && mode != Mode::kLidar && mode != Mode::kManual;
  if (mode == Mode::kCamera || has_camera) request({stamp, stamp, Stamp{}, Stamp{}, stamp});
}

void BaseControllerNode::onObstacle(const Obstacle& msg) {
  obstacle_stamp_ = toStamp(msg.header.stamp);
  const std::optional<NearestObstacle> obstacle = fromRos(msg);
  if (msg.found && msg.header.frame_id != params_.odom_frame) {
    control_.refuse("obstacle/nearest",
                    "it is in \"" + msg.header.frame_id + "\", not in \"" + params_.odom_frame + "\"");
    note("obstacle/nearest", false, obstacle_stamp_);
  } else if (obstacle) {
    note("obstacle/nearest", control_.setObstacle(*obstacle), obstacle_stamp_);
  } else {
    control_.refuse("obstacle/nearest", "not finite");
    note("obstacle/nearest", false, obstacle_stamp_);
  }
  cycleWhenReady();
}

void BaseControllerNode::onDepthScan(const sensor_msgs::LaserScan& msg) {
  depth_stamp_ = toStamp(msg.header.stamp);
  if (msg.header.frame_id == params_.base_frame) {
    note("depth/scan", control_.setDepthScan(fromRos(msg)), *depth_stamp_);
  } else {
    control_.refuse("depth/scan",
                    "it is in \"" + msg.header.frame_id + "\", not in \"" + params_.base_frame + "\"");
    note("depth/scan", false, *depth_stamp_);
  }
  cycleWhenReady();
}

void BaseControllerNode::onMissionCommand(const geometry_msgs::TwistStamped& msg) {
  mission_command_stamp_ = toStamp(msg.header.stamp);
  note("mission/command", control_.setMissionCommand(planar(msg.twist), mission_command_stamp_),
       mission_command_stamp_);
  cycleWhenReady();
}

void BaseControllerNode::onManualCommand(const geometry_msgs::TwistStamped& msg) {
  const Stamp stamp = toStamp(msg.header.stamp);
  note("cmd_vel_in", control_.setManualCommand(planar(msg.twist), stamp), stamp);
}

void BaseControllerNode::onTimer() {
  // Half a period of slack, so that a timer in step with its own cycles skips none of them.
  const ros::Time now = ros::Time::now();
  if (now < last_cycle_ || (now - last_cycle_).toSec() > 0.5 / params_.rate_hz) cycle();
}

void BaseControllerNode::note(const std::string& topic, bool accepted, Stamp stamp) {
  if (accepted) {
    diagnostics_.input(topic).received(stamp, toStamp(ros::Time::now()));
  } else {
    diagnostics_.input(topic).refused(control_.refusal(topic));
    ROS_WARN_THROTTLE(1.0, "%s", control_.refusal(topic).c_str());
  }
}

void BaseControllerNode::request(const Pending& pending) {
  pending_ = pending;
  cycleWhenReady();
}

void BaseControllerNode::cycleWhenReady() {
  if (pending_ && odom_stamp_ >= pending_->odom && scan_stamp_ >= pending_->scan &&
      mission_command_stamp_ >= pending_->mission_command && obstacle_stamp_ >= pending_->camera &&
      (!depth_stamp_ || *depth_stamp_ >= pending_->camera)) {
    stamp_ = pending_->stamp;
    pending_.reset();
    cycle();
  }
}

void BaseControllerNode::cycle() {
  last_cycle_ = ros::Time::now();
  BaseCommand command;
  if (last_cycle_.isZero()) {  // simulated time that has not begun: nothing can be said of any input's age
    command.reason = BaseCommand::Reason::kMissing;
    command.text = "no time on /clock yet";
  } else {
    command = control_.cycle(toStamp(last_cycle_));
  }
  publish(command.velocity, stamp_);
  report(command);
  show(command);
  last_ = command;
}

void BaseControllerNode::publish(const Twist2& velocity, Stamp stamp) {
  geometry_msgs::TwistStamped msg;
  msg.header.stamp = toRos(stamp);
  msg.header.frame_id = params_.base_frame;
  msg.twist = toRos(velocity);
  cmd_vel_pub_.publish(msg.twist);
  cmd_vel_stamped_pub_.publish(msg);
}

void BaseControllerNode::report(const BaseCommand& command) {
  if (control_.timeJumps() > reported_jumps_) {
    ROS_WARN("time jumped back: the base stands until fresh inputs are in");
    reported_jumps_ = control_.timeJumps();
  }
  const bool fault = isFault(command.reason);
  if (fault && last_.reason != command.reason) {
    const bool waits = command.reason == BaseCommand::Reason::kMissing;
    ROS_LOG(waits ? ros::console::levels::Info : ros::console::levels::Warn, ROSCONSOLE_DEFAULT_NAME,
            "the base %s: %s", waits ? "waits" : "stands", command.text.c_str());
  }
  const bool moves = command.reason == BaseCommand::Reason::kNone;
  if (moves && isFault(last_.reason)) ROS_INFO("the base is free to move again");
  diagnostics_.status(fault ? diagnostic_msgs::DiagnosticStatus::WARN : diagnostic_msgs::DiagnosticStatus::OK,
                      command.text.empty() ? "follows " + std::string(nameOf(command.source)) : command.text);
  diagnostics_.set("source", nameOf(command.source));
  diagnostics_.set("collision stop leaves", command.guard_share);
  diagnostics_.set("time jumps", static_cast<double>(control_.timeJumps()));
}

void BaseControllerNode::show(const BaseCommand& command) const {
  if (markers_pub_.getNumSubscribers() == 0) return;
  markers_pub_.publish(barrierMarkers(command, stamp_, control_.footprint(), params_.base_frame));
}

void BaseControllerNodelet::onInit() {
  node_ = makeNode<BaseControllerNode>(getNodeHandle(), getPrivateNodeHandle());
  last_word_ = std::make_unique<LastWord>(*getNodeHandle().getCallbackQueue(), [this] { node_->stop(); });
}

}  // namespace frugal_nav
