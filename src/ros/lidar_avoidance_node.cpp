#include <frugal_nav/LocalCommand.h>
#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/lidar_avoidance_node.hpp>
#include <frugal_nav/ros/parameters.hpp>
#include <frugal_nav/ros/planning_markers.hpp>

namespace frugal_nav {
namespace {

LidarAvoidanceNodeParams load(const ros::NodeHandle& pnh) {
  LidarAvoidanceNodeParams params;
  loadParameters(pnh, params);
  return params;
}

}  // namespace

LidarAvoidanceNode::LidarAvoidanceNode(ros::NodeHandle nh, ros::NodeHandle pnh)
    : params_(load(pnh)),
      body_(extentOf(loadRobotDescription(nh, params_.intake.base_frame))),
      avoidance_(params_.avoidance, body_),
      diagnostics_(nh, pnh) {
  diagnostics_.input("path");
  command_pub_ = nh.advertise<LocalCommand>("avoidance/command", 5);
  markers_pub_ = nh.advertise<visualization_msgs::MarkerArray>("avoidance/markers", 1);
  intake_ = std::make_unique<ScanIntake>(
      nh, params_.intake, params_.scan, diagnostics_,
      ScanIntake::Callbacks{[this](const PosedScan& posed) { return hasPathFor(posed); },
                            [this](const PosedScan& posed) { process(posed); },
                            [this] { avoidance_.reset(); }});
  path_sub_ = nh.subscribe("path", 5, &LidarAvoidanceNode::onPath, this, ros::TransportHints().tcpNoDelay());
  live_ = tuneLive<LidarAvoidanceNodeParams>(pnh, params_, [this](const LidarAvoidanceNodeParams& wanted) {
    params_.avoidance = wanted.avoidance;
    avoidance_.setParams(params_.avoidance);
    intake_->setRules(wanted.scan);
  });
}

void LidarAvoidanceNode::onPath(const nav_msgs::Path& msg) {
  const std::optional<Path2> path = fromRos(msg);
  if (!path || msg.header.frame_id != params_.intake.odom_frame) {
    diagnostics_.input("path").refused(path ? "not in the frame " + params_.intake.odom_frame
                                            : "not finite, or no sound quaternion");
    return;
  }
  const Stamp stamp = toStamp(msg.header.stamp);
  intake_->checkStamp("path", stamp);
  diagnostics_.input("path").received(stamp, toStamp(ros::Time::now()));
  avoidance_.setPath(stamp, *path);
  intake_->process();
}

// A scan waits for the path that rests on it, so that a slow machine gives the same commands as a fast one.
bool LidarAvoidanceNode::hasPathFor(const PosedScan& posed) {
  avoidance_.setGoal(intake_->goal());
  if (!avoidance_.needsPath()) return true;
  const std::optional<Stamp> newest = avoidance_.pathStamp();
  return (newest && *newest >= posed.scan.stamp) || intake_->waited_s() > params_.avoidance.path_timeout_s;
}

void LidarAvoidanceNode::process(const PosedScan& posed) {
  MotionCommand command;
  command.stamp = posed.scan.stamp;
  command.status = MotionCommand::Status::kStopped;
  command.reason = posed.fault;
  if (posed.fault.empty()) {
    const ros::WallTime start = ros::WallTime::now();
    command = avoidance_.update(posed.scan, posed.base_from_laser, posed.odometry);
    diagnostics_.set("time of a decision [ms]", (ros::WallTime::now() - start).toSec() * 1e3);
  }
  command.goal_number = intake_->goalNumber();
  command_pub_.publish(toRos(command, params_.intake.odom_frame));
  report(command);
  if (!posed.fault.empty() || markers_pub_.getNumSubscribers() == 0) return;
  if (const auto shown = avoidance_.directions(posed.odometry.odom_from_base.yaw_rad))
    markers_pub_.publish(
        sectorMarkers(*shown, command, params_.intake.base_frame, params_.intake.odom_frame));
}

void LidarAvoidanceNode::report(const MotionCommand& command) {
  using diagnostic_msgs::DiagnosticStatus;
  using Status = MotionCommand::Status;
  const bool well = command.status == Status::kIdle || command.status == Status::kDriving;
  diagnostics_.status(well ? DiagnosticStatus::OK : DiagnosticStatus::WARN,
                      command.reason.empty() ? "driving" : command.reason);
  if (!well) ROS_WARN_THROTTLE(5.0, "%s", command.reason.c_str());
}

}  // namespace frugal_nav
