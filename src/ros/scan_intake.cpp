#include <algorithm>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/scan_intake.hpp>

namespace frugal_nav {
namespace {

constexpr double kCheckPeriod_s = 0.05;
constexpr std::size_t kMostPending = 10;  // a second of scans: then the oldest is given up

bool isUnderway(MissionPhase phase) {
  return phase == MissionPhase::kDriving || phase == MissionPhase::kRecovering;
}

}  // namespace

ScanIntake::ScanIntake(ros::NodeHandle nh, const IntakeParams& params, const ScanRules& rules,
                       NodeDiagnostics& diagnostics, Callbacks callbacks)
    : params_(params),
      rules_(rules),
      diagnostics_(diagnostics),
      callbacks_(std::move(callbacks)),
      time_([this](Stamp now) { forget(now); }),
      sensors_(params.base_frame),
      odometry_(nh, params, diagnostics, time_, [this] { process(); }) {
  for (const char* topic : {"scan", "mission/goal", "mission/state"}) diagnostics_.input(topic);
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  goal_sub_ = nh.subscribe("mission/goal", 1, &ScanIntake::onGoal, this, hints);
  state_sub_ = nh.subscribe("mission/state", 10, &ScanIntake::onState, this, hints);
  scan_sub_ = nh.subscribe("scan", 5, &ScanIntake::onScan, this, hints);
  timer_ = nh.createTimer(ros::Duration(kCheckPeriod_s), [this](const ros::TimerEvent&) { onTimer(); });
}

void ScanIntake::onScan(const sensor_msgs::LaserScan& msg) {
  const Stamp stamp = toStamp(msg.header.stamp);
  if (stamp == last_scan_) {
    diagnostics_.input("scan").dropped("the same stamp twice");
    return;
  }
  checkStamp("scan", stamp);
  last_scan_ = stamp;
  diagnostics_.input("scan").received(stamp, toStamp(ros::Time::now()));
  Pending pending;
  pending.posed.scan = readBy(rules_, fromRos(msg));
  pending.posed.frame = msg.header.frame_id;
  pending.since = ros::Time::now();
  if (const auto fault = findFault(pending.posed.scan, rules_)) {
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

void ScanIntake::onGoal(const geometry_msgs::PoseStamped& msg) {
  const std::optional<Pose2> goal = planar(msg.pose);
  if (!goal || msg.header.frame_id != params_.odom_frame) {
    diagnostics_.input("mission/goal")
        .refused(goal ? "not in the frame " + params_.odom_frame : "not finite, or no sound quaternion");
    return;
  }
  diagnostics_.input("mission/goal").received(toStamp(msg.header.stamp), toStamp(ros::Time::now()));
  time_.checkClock();
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
  time_.checkClock();
  if (status->goal_number != mission_.goal_number) number_before_ = mission_.stamp;
  mission_ = *status;
  // Goal and state come on different connections: an end that is older than the goal is another's.
  if (!isUnderway(mission_.phase) && goal_stamp_ < mission_.stamp) goal_.reset();
}

bool ScanIntake::isActive() const {
  // While the mission aligns or recovers by itself, it wants to know whether the way is free again.
  const bool by_lidar =
      mission_.mode == Mode::kLidar || mission_.mode == Mode::kAligning || mission_.mode == Mode::kRecovering;
  // Goal and state come on different connections: a goal older than the number is the one before.
  return isUnderway(mission_.phase) && by_lidar && goal_stamp_ >= number_before_;
}

void ScanIntake::onTimer() {
  time_.checkClock();
  process();
}

void ScanIntake::forget(Stamp now) {
  pending_.clear();
  odometry_.clear();
  last_scan_.reset();
  number_before_ = Stamp{};
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
  const std::variant<Pose2, std::string> laser = sensors_.laser(posed.frame);
  if (const auto* fault = std::get_if<std::string>(&laser)) {
    diagnostics_.input("scan").dropped(posed.fault = *fault);
    return true;
  }
  posed.base_from_laser = std::get<Pose2>(laser);
  pending.since = std::min(pending.since, ros::Time::now());  // which may have jumped back
  const OdometryIntake::Answer answer = odometry_.at("scan", posed.scan.stamp, waited_s());
  if (answer.odometry) {
    posed.odometry = *answer.odometry;
    return callbacks_.ready(posed);
  }
  if (!answer.isFinal()) return false;
  posed.fault = answer.fault;
  diagnostics_.input("scan").dropped(posed.fault);
  return true;
}

}  // namespace frugal_nav
