#include <algorithm>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/scan_intake.hpp>

namespace frugal_nav {
namespace {

constexpr double kCheckPeriod_s = 0.05;
constexpr double kSilentAfter_s = 2.0;
constexpr std::size_t kMostPending = 10;  // a second of scans: then the oldest is given up

}  // namespace

ScanIntake::ScanIntake(ros::NodeHandle nh, const IntakeParams& params, const ScanRules& rules,
                       NodeDiagnostics& diagnostics, Callbacks callbacks)
    : params_(params),
      rules_(rules),
      diagnostics_(diagnostics),
      callbacks_(std::move(callbacks)),
      time_([this](Stamp now) { forget(now); }),
      sensors_(params.base_frame),
      goal_(nh, params.odom_frame, Mode::kLidar, diagnostics, time_),
      odometry_(nh, params, diagnostics, time_, [this] { process(); }) {
  diagnostics_.input("scan");
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
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
  silence_.heard(ros::Time::now());
  diagnostics_.input("scan").received(stamp, toStamp(ros::Time::now()));
  Pending pending;
  pending.posed.scan = readBy(rules_, fromRos(msg));
  pending.posed.frame = msg.header.frame_id;
  pending.since = ros::Time::now();
  std::optional<std::string> fault = findFault(pending.posed.scan, rules_);
  if (!fault) fault = findAngleFault(msg);
  if (fault) {
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

void ScanIntake::onTimer() {
  time_.checkClock();
  process();
  watchSilence();
}

void ScanIntake::watchSilence() {
  if (!silence_.isSilent(ros::Time::now(), kSilentAfter_s)) return;
  const std::string silence = "no scan on " + scan_sub_.getTopic() + ": is the laser's driver running?";
  diagnostics_.status(diagnostic_msgs::DiagnosticStatus::WARN, silence);
  ROS_WARN_THROTTLE(10.0, "%s", silence.c_str());
}

void ScanIntake::forget(Stamp now) {
  pending_.clear();
  odometry_.clear();
  last_scan_.reset();
  goal_.forget(now);
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
