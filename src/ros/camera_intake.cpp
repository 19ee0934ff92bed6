#include <algorithm>

#include <frugal_nav/ros/camera_intake.hpp>
#include <frugal_nav/ros/conversions.hpp>

namespace frugal_nav {
namespace {

constexpr std::size_t kMostPending = 10;  // then the oldest is given up

void addFault(CameraObservation& observation, const std::string& fault) {
  if (observation.fault.empty()) observation.fault = fault;
}

}  // namespace

CameraIntake::CameraIntake(ros::NodeHandle nh, const IntakeParams& params, double input_wait_s,
                           NodeDiagnostics& diagnostics, TimeJumpWatch& time, Process process)
    : params_(params),
      input_wait_s_(input_wait_s),
      diagnostics_(diagnostics),
      time_(time),
      process_(std::move(process)),
      odometry_(nh, params, diagnostics, time, [this] { this->process(); }) {
  for (const char* topic : {"gap", "obstacle/nearest", "depth/scan"}) diagnostics_.input(topic);
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  gap_sub_ = nh.subscribe("gap", 5, &CameraIntake::onGap, this, hints);
  obstacle_sub_ = nh.subscribe("obstacle/nearest", 5, &CameraIntake::onObstacle, this, hints);
  scan_sub_ = nh.subscribe("depth/scan", 5, &CameraIntake::onScan, this, hints);
}

void CameraIntake::clear() {
  pending_.clear();
  odometry_.clear();
  handed_on_.reset();
}

CameraIntake::Pending* CameraIntake::pendingFor(const std::string& input, const std_msgs::Header& header,
                                                const std::string& frame) {
  const Stamp stamp = toStamp(header.stamp);
  time_.checkStamp(input, stamp);
  if (handed_on_ && stamp <= *handed_on_) {
    diagnostics_.input(input).dropped("too late: its image has been planned with");
    return nullptr;
  }
  diagnostics_.input(input).received(stamp, toStamp(ros::Time::now()));
  const auto [entry, is_new] = pending_.try_emplace(stamp);
  if (is_new) {
    entry->second.observation.stamp = stamp;
    entry->second.since = ros::Time::now();
  }
  if (header.frame_id != frame) {
    addFault(entry->second.observation,
             input + " is in the frame \"" + header.frame_id + "\" instead of \"" + frame + "\"");
    diagnostics_.input(input).refused(entry->second.observation.fault);
  }
  return &entry->second;
}

void CameraIntake::onGap(const Gap& msg) {
  Pending* pending = pendingFor("gap", msg.header, params_.odom_frame);
  if (pending == nullptr) return;
  pending->has_gap = true;
  if (const std::optional<GapSighting> gap = fromRos(msg)) {
    pending->observation.gap = *gap;
  } else {
    addFault(pending->observation, "gap is not finite");
    diagnostics_.input("gap").refused("not finite");
  }
  process();
}

void CameraIntake::onObstacle(const Obstacle& msg) {
  Pending* pending = pendingFor("obstacle/nearest", msg.header, params_.odom_frame);
  if (pending == nullptr) return;
  pending->has_obstacle = true;
  if (const std::optional<NearestObstacle> obstacle = fromRos(msg)) {
    pending->observation.obstacle = *obstacle;
    // Not found for a reason: the image was of no use.
    if (!obstacle->found && !obstacle->reason.empty()) addFault(pending->observation, obstacle->reason);
  } else {
    addFault(pending->observation, "obstacle/nearest is not finite");
    diagnostics_.input("obstacle/nearest").refused("not finite");
  }
  process();
}

void CameraIntake::onScan(const sensor_msgs::LaserScan& msg) {
  Pending* pending = pendingFor("depth/scan", msg.header, params_.base_frame);
  if (pending == nullptr) return;
  pending->has_scan = true;
  pending->observation.scan = fromRos(msg);
  process();
}

void CameraIntake::process() {
  while (!pending_.empty()) {
    const bool later_is_whole = pending_.size() > kMostPending ||
                                std::any_of(std::next(pending_.begin()), pending_.end(),
                                            [](const auto& entry) { return entry.second.isWhole(); });
    if (!complete(pending_.begin()->second, later_is_whole)) return;
    const CameraObservation observation = std::move(pending_.begin()->second.observation);
    handed_on_ = observation.stamp;
    pending_.erase(pending_.begin());
    process_(observation);
  }
}

/// Whether an image can be handed on: everything is there, or will not come any more.
bool CameraIntake::complete(Pending& pending, bool later_is_whole) {
  CameraObservation& observation = pending.observation;
  pending.since = std::min(pending.since, ros::Time::now());  // which may have jumped back
  const double waited_s = (ros::Time::now() - pending.since).toSec();
  if (!pending.isWhole()) {
    if (waited_s <= input_wait_s_ && !later_is_whole) return false;
    const char* missing = !pending.has_gap        ? "gap"
                          : !pending.has_obstacle ? "obstacle/nearest"
                                                  : "depth/scan";
    addFault(observation, std::string("no ") + missing + " for an image");
    diagnostics_.input(missing).dropped(observation.fault);
    return true;
  }
  const OdometryIntake::Answer answer = odometry_.at("image", observation.stamp, waited_s);
  if (answer.odometry) observation.odometry = *answer.odometry;
  if (!answer.fault.empty()) {
    addFault(observation, answer.fault);
    diagnostics_.input("odom").dropped(answer.fault);
  }
  return answer.isFinal();
}

}  // namespace frugal_nav
