#include <algorithm>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/scan_intake.hpp>

namespace frugal_nav {
namespace {

constexpr double kCheckPeriod_s = 0.05;
constexpr std::size_t kMostPending = 10;  // a second of scans: then the oldest is given up

/// The pose of a level laser on the floor plane; nothing when it is not mounted level.
std::optional<Pose2> levelPose(const geometry_msgs::Transform& transform) {
  const geometry_msgs::Quaternion& q = transform.rotation;
  const std::optional<double> yaw = yawOf(q);
  const double up = 1.0 - 2.0 * (q.x * q.x + q.y * q.y);  // z of its z axis
  if (!yaw || up < 0.99) return std::nullopt;
  return Pose2{transform.translation.x, transform.translation.y, *yaw};
}

bool isUnderway(MissionPhase phase) {
  return phase == MissionPhase::kDriving || phase == MissionPhase::kRecovering;
}

}  // namespace

ScanIntake::ScanIntake(ros::NodeHandle nh, const ScanIntakeParams& params, NodeDiagnostics& diagnostics,
                       Callbacks callbacks)
    : params_(params), diagnostics_(diagnostics), callbacks_(std::move(callbacks)) {
  for (const char* topic : {"scan", "odom", "mission/goal", "mission/state"}) diagnostics_.input(topic);
  tf_listener_ = std::make_unique<tf2_ros::TransformListener>(tf_buffer_);
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  goal_sub_ = nh.subscribe("mission/goal", 1, &ScanIntake::onGoal, this, hints);
  state_sub_ = nh.subscribe("mission/state", 10, &ScanIntake::onState, this, hints);
  odometry_sub_ = nh.subscribe("odom", 50, &ScanIntake::onOdometry, this, hints);
  scan_sub_ = nh.subscribe("scan", 5, &ScanIntake::onScan, this, hints);
  timer_ = nh.createTimer(ros::Duration(kCheckPeriod_s), [this](const ros::TimerEvent&) { onTimer(); });
}

void ScanIntake::onScan(const sensor_msgs::LaserScan& msg) {
  const Stamp stamp = toStamp(msg.header.stamp);
  const auto last = last_stamps_.find("scan");
  if (last != last_stamps_.end() && last->second == stamp) {
    diagnostics_.input("scan").dropped("the same stamp twice");
    return;
  }
  checkStamp("scan", stamp);
  diagnostics_.input("scan").received(stamp, toStamp(ros::Time::now()));
  Pending pending;
  pending.posed.scan = fromRos(msg);
  pending.posed.frame = msg.header.frame_id;
  pending.since = ros::Time::now();
  if (const auto fault = findFault(pending.posed.scan)) {
    pending.posed.fault = *fault;
    diagnostics_.input("scan").refused(*fault);
  }
  pending_.push_back(std::move(pending));
  if (pending_.size() > kMostPending) {
    pending_.front().posed.fault = "more scans than can be processed";
    diagnostics_.input("scan").dropped(pending_.front().posed.fault);
  }
  process();
}

void ScanIntake::onOdometry(const nav_msgs::Odometry& msg) {
  const std::optional<Odometry> odometry = fromRos(msg);
  if (!odometry) {
    diagnostics_.input("odom").refused("not finite, or no sound quaternion");
    return;
  }
  if (msg.header.frame_id != params_.odom_frame) {
    diagnostics_.input("odom").refused("frame \"" + msg.header.frame_id + "\" instead of \"" +
                                       params_.odom_frame + "\"");
    return;
  }
  checkStamp("odom", odometry->stamp);
  diagnostics_.input("odom").received(odometry->stamp, toStamp(ros::Time::now()));
  odometry_.add(*odometry);
  process();
}

void ScanIntake::onGoal(const geometry_msgs::PoseStamped& msg) {
  const std::optional<Pose2> goal = planar(msg.pose);
  if (!goal || msg.header.frame_id != params_.odom_frame) {
    diagnostics_.input("mission/goal")
        .refused(goal ? "not in the frame " + params_.odom_frame : "not finite, or no sound quaternion");
    return;
  }
  diagnostics_.input("mission/goal").received(toStamp(msg.header.stamp), toStamp(ros::Time::now()));
  checkClock();
  goal_ = *goal;
  goal_stamp_ = toStamp(msg.header.stamp);
}

void ScanIntake::onState(const MissionState& msg) {
  const std::optional<MissionStatus> status = fromRos(msg);
  if (!status) {
    diagnostics_.input("mission/state").refused("unknown mode or state");
    return;
  }
  diagnostics_.input("mission/state").received(status->stamp, toStamp(ros::Time::now()));
  checkClock();
  mission_ = *status;
  // Goal and state come on different connections: an end that is older than the goal is another's.
  if (!isUnderway(mission_.phase) && goal_stamp_ < mission_.stamp) goal_.reset();
}

bool ScanIntake::isActive() const {
  // While the mission aligns or recovers by itself, it wants to know whether the way is free again.
  const bool by_lidar =
      mission_.mode == Mode::kLidar || mission_.mode == Mode::kAligning || mission_.mode == Mode::kRecovering;
  return isUnderway(mission_.phase) && by_lidar;
}

void ScanIntake::onTimer() {
  checkClock();
  process();
}

// Clock and messages come on different connections, so that one jump shows twice, in either order.
void ScanIntake::checkClock() {
  const ros::Time now = ros::Time::now();
  if (now < last_now_ && !stamps_jumped_) forget("ROS time", toStamp(now));
  if (now < last_now_) {
    stamps_jumped_ = false;
    for (Pending& pending : pending_) pending.since = std::min(pending.since, now);
  }
  last_now_ = now;
}

void ScanIntake::checkStamp(const std::string& input, Stamp stamp) {
  checkClock();
  const auto last = last_stamps_.find(input);
  if (last != last_stamps_.end() && stamp < last->second) {
    forget(input, stamp);
    stamps_jumped_ = true;
  }
  last_stamps_[input] = stamp;
}

void ScanIntake::forget(const std::string& why, Stamp now) {
  ROS_WARN("time jumped back (%s): starting anew", why.c_str());
  pending_.clear();
  odometry_.clear();
  last_stamps_.clear();
  mission_ = MissionStatus{};            // stands until the mission speaks again
  if (goal_stamp_ > now) goal_.reset();  // not one of the new time that has come already
  callbacks_.time_jumped();
}

double ScanIntake::waited_s() const {
  return pending_.empty() ? 0.0 : (ros::Time::now() - pending_.front().since).toSec();
}

void ScanIntake::process() {
  while (!pending_.empty() && complete(pending_.front())) {
    const PosedScan posed = std::move(pending_.front().posed);
    pending_.pop_front();
    callbacks_.process(posed);
  }
}

/// Whether a scan can be handed on: everything is there, or will not come any more.
bool ScanIntake::complete(Pending& pending) {
  PosedScan& posed = pending.posed;
  if (!posed.fault.empty()) return true;
  const std::optional<Pose2> laser = laserPose(posed.frame);
  if (!laser) {
    diagnostics_.input("scan").dropped(posed.fault =
                                           "no transform from " + params_.base_frame + " to " + posed.frame);
    return true;
  }
  posed.base_from_laser = *laser;
  if (odometry_.covers(posed.scan.stamp)) {
    posed.odometry = *odometry_.at(posed.scan.stamp);
    return callbacks_.ready(posed);
  }
  const bool too_old = !odometry_.empty() && posed.scan.stamp < odometry_.newest().stamp;
  if (!too_old && waited_s() <= params_.odom_wait_s) return false;
  posed.fault = too_old ? "the scan is older than the odometry kept" : "no odometry for the scan's stamp";
  diagnostics_.input("scan").dropped(posed.fault);
  return true;
}

std::optional<Pose2> ScanIntake::laserPose(const std::string& frame) {
  const auto known = base_from_laser_.find(frame);
  if (known != base_from_laser_.end()) return known->second;
  if (!tf_listener_) tf_listener_ = std::make_unique<tf2_ros::TransformListener>(tf_buffer_);
  try {
    const auto transform = tf_buffer_.lookupTransform(params_.base_frame, frame, ros::Time(0)).transform;
    const std::optional<Pose2> pose = levelPose(transform);
    if (!pose) {
      ROS_ERROR_THROTTLE(5.0, "laser frame \"%s\" is not level in \"%s\": its scans are not used",
                         frame.c_str(), params_.base_frame.c_str());
      return std::nullopt;
    }
    base_from_laser_[frame] = *pose;
    tf_listener_.reset();
    return pose;
  } catch (const tf2::TransformException& error) {
    ROS_WARN_THROTTLE(5.0, "no transform from %s to %s: %s", params_.base_frame.c_str(), frame.c_str(),
                      error.what());
    return std::nullopt;
  }
}

}  // namespace frugal_nav
