#include <algorithm>
#include <cmath>

#include <frugal_nav/control/base_control.hpp>

namespace frugal_nav {
namespace {

// The time a command is taken to have acted when none came before it, and the most one is taken to have.
constexpr double kCycle_s = 0.05;

BaseCommand stopped(BaseCommand::Reason reason, std::string text) {
  BaseCommand command;
  command.reason = reason;
  command.text = std::move(text);
  return command;
}

BaseCommand driving(BaseCommand::Source source, const Twist2& velocity) {
  BaseCommand command;
  command.source = source;
  command.velocity = velocity;
  return command;
}

const char* sourceTopic(Mode mode) {
  switch (mode) {
    case Mode::kLidar:
      return "avoidance/command";
    case Mode::kCamera:
      return "path";
    case Mode::kAligning:
    case Mode::kRecovering:
      return "mission/command";
    case Mode::kManual:
      return "cmd_vel_in";
    case Mode::kIdle:
      break;
  }
  return nullptr;
}

}  // namespace

BaseControl::BaseControl(const BaseControlParams& params, const BaseGeometry& geometry)
    : params_(params),
      geometry_(geometry),
      waypoint_(params.waypoint),
      follower_(params.path),
      limiter_(params.limits, geometry.wheel_separation_m),
      guard_(params.guard, geometry.footprint),
      depth_(params.depth),
      near_(params.near) {
  setParams(params);
}

void BaseControl::setParams(const BaseControlParams& params) {
  validate(params, "base control");
  params_ = params;
  depth_.setParams(params.depth);
  near_.setParams(params.near);
  waypoint_ = WaypointController(params.waypoint);
  follower_ = PathFollower(params.path);
  limiter_ = VelocityLimiter(params.limits, geometry_.wheel_separation_m);
  guard_ = CollisionGuard(params.guard, geometry_.footprint);
  watchdog_.watch("odom", params.timeouts.odom_s);
  watchdog_.watch("scan", params.timeouts.scan_s);
  watchdog_.watch("mission/state", params.timeouts.mission_state_s);
  watchdog_.watch("mission/command", params.timeouts.mission_command_s);
  watchdog_.watch("avoidance/command", params.timeouts.avoidance_command_s);
  watchdog_.watch("path", params.timeouts.path_s);
  watchdog_.watch("obstacle/nearest", params.timeouts.obstacle_s);
  watchdog_.watch("depth/scan", params.timeouts.depth_scan_s);
  watchdog_.watch("cmd_vel_in", params.timeouts.cmd_vel_in_s);
}

void BaseControl::reset() {
  watchdog_.reset();
  blind_.reset();
  follower_.reset();
  odometry_.clear();
  mission_ = {};
  goal_since_ = {};
  p_base_at_scan_.clear();
  depth_.clear();
  near_.clear();
  obstacle_ = {};
  refused_.clear();
  last_now_.reset();
  issued_ = before_ = {};
  issued_at_.reset();
  before_at_.reset();
}

BaseCommand BaseControl::cycle(Stamp now) {
  if (last_now_ && now < *last_now_) {
    reset();
    time_jumped_ = true;
    ++time_jumps_;
  }
  last_now_ = now;
  const Stamp at = newestStamp(now);
  if (!issued_at_ || at > *issued_at_) {
    before_ = issued_;
    before_at_ = issued_at_;
  }
  BaseCommand command = decide(at);
  command.stamp = sensorStamp();
  if (command.reason == BaseCommand::Reason::kMissing && time_jumped_) {
    command.text = "time jumped back; " + command.text;
  } else if (command.reason == BaseCommand::Reason::kNone) {
    time_jumped_ = false;
  }
  issued_ = command.velocity;
  issued_at_ = at;
  return command;
}

BaseCommand BaseControl::decide(Stamp now) {
  if (watchdog_.last("mission/state") == Stamp{} && refusal("mission/state").empty())
    return stopped(BaseCommand::Reason::kMissing, "mission has no odometry yet");
  if (const auto fault = faultOf("mission/state", now)) return *fault;
  if (mission_.mode == Mode::kIdle) return stopped(BaseCommand::Reason::kIdle, mission_.reason);
  for (const std::string& input : requiredInputs()) {
    if (const auto fault = faultOf(input, now)) return *fault;
  }
  const Odometry odometry = *odometry_.predictedAt(now);
  const BaseCommand command = wanted(now, odometry.odom_from_base);
  if (command.reason != BaseCommand::Reason::kNone) return command;
  return restrict(command, now, odometry);
}

std::vector<std::string> BaseControl::requiredInputs() const {
  std::vector<std::string> inputs{"odom"};
  const bool by_hand = mission_.mode == Mode::kManual;
  if (has_scanner_ || mission_.mode == Mode::kLidar ||
      (by_hand ? params_.require_scan_in_manual : params_.require_scan)) {
    inputs.emplace_back("scan");  // before what rests on it, so that the cause is named
  }
  inputs.emplace_back(sourceTopic(mission_.mode));
  if (mission_.mode == Mode::kCamera) {
    inputs.emplace_back("obstacle/nearest");
    if (has_depth_) inputs.emplace_back("depth/scan");
  }
  return inputs;
}

std::optional<BaseCommand> BaseControl::faultOf(const std::string& input, Stamp now) const {
  const auto refused = refused_.find(input);
  if (refused != refused_.end()) return stopped(BaseCommand::Reason::kRefused, refused->second);
  const std::optional<Stamp> last = watchdog_.last(input);
  if (last && *last > now) {
    return stopped(BaseCommand::Reason::kRefused, input + " is stamped in the future: do the clocks agree?");
  }
  const std::optional<std::string> fault = watchdog_.fault(input, now);
  if (!fault) return std::nullopt;
  return stopped(last ? BaseCommand::Reason::kStale : BaseCommand::Reason::kMissing, *fault);
}

Stamp BaseControl::newestStamp(Stamp now) const {
  // The clock's message may come after those of its instant: the newest input within the tolerance is "now".
  Stamp newest = now;
  for (const char* input : {"odom", "scan", "mission/state", "mission/command", "avoidance/command", "path",
                            "obstacle/nearest", "depth/scan", "cmd_vel_in"}) {
    const std::optional<Stamp> last = watchdog_.last(input);
    if (last && *last <= now + fromSeconds(params_.future_tolerance_s)) newest = std::max(newest, *last);
  }
  return newest;
}

Stamp BaseControl::sensorStamp() const {
  Stamp newest = std::max(watchdog_.last("odom").value_or(Stamp{}), watchdog_.last("scan").value_or(Stamp{}));
  if (mission_.mode == Mode::kCamera) {
    for (const char* input : {"path", "obstacle/nearest", "depth/scan"})
      newest = std::max(newest, watchdog_.last(input).value_or(Stamp{}));
  }
  return newest;
}

BaseCommand BaseControl::wanted(Stamp now, const Pose2& odom_from_base) {
  switch (mission_.mode) {
    case Mode::kLidar:
      return localCommand(odom_from_base);
    case Mode::kCamera:
      return pathCommand(now, odom_from_base);
    case Mode::kAligning:
    case Mode::kRecovering:
      return driving(BaseCommand::Source::kMission, mission_command_);
    case Mode::kManual:
      return driving(BaseCommand::Source::kManual, manual_command_);
    case Mode::kIdle:
      break;
  }
  return stopped(BaseCommand::Reason::kIdle, mission_.reason);
}

BaseCommand BaseControl::localCommand(const Pose2& odom_from_base) const {
  if (local_command_.stamp <= goal_since_ || local_command_.goal_number != mission_.goal_number) {
    return stopped(BaseCommand::Reason::kMissing, "no avoidance/command for the new goal yet");
  }
  switch (local_command_.holds) {
    case MotionCommand::Holds::kTarget:
      return driving(BaseCommand::Source::kAvoidance,
                     waypoint_.command(odom_from_base, local_command_.odom_from_target.position()));
    case MotionCommand::Holds::kVelocity:
      return driving(BaseCommand::Source::kAvoidance, local_command_.velocity);
    case MotionCommand::Holds::kNothing:
      break;
  }
  return stopped(BaseCommand::Reason::kNoWay, local_command_.reason);
}

BaseCommand BaseControl::pathCommand(Stamp now, const Pose2& odom_from_base) {
  if (*watchdog_.last("path") <= goal_since_) {
    return stopped(BaseCommand::Reason::kMissing, "no path for the new goal yet");
  }
  if (path_.empty()) return stopped(BaseCommand::Reason::kNoWay, "the path is empty");
  return driving(BaseCommand::Source::kPath, follower_.command(path_, odom_from_base, now));
}

BaseCommand BaseControl::restrict(const BaseCommand& command, Stamp now, const Odometry& odometry) {
  const auto obstacles = obstaclesAt(now, odometry.odom_from_base);
  if (!obstacles) return stopped(BaseCommand::Reason::kMissing, "no odometry at the stamp of the scan");
  const std::vector<Eigen::Vector2d>& p_base = *obstacles;
  Twist2 velocity = limiter_.limitSpeed(command.velocity);
  if (isBlind(velocity.v_mps) && std::abs(velocity.v_mps) > params_.blind_mps) {
    const double factor = params_.blind_mps / std::abs(velocity.v_mps);
    velocity = {factor * velocity.v_mps, factor * velocity.w_radps};
  }
  const double stopping_m = velocity.v_mps * velocity.v_mps / (2.0 * params_.limits.decel_mps2);
  velocity = limiter_.limitForObstacles(velocity, guard_.freeDistance(velocity, stopping_m, p_base));
  const double elapsed_s = before_at_ ? std::min(toSeconds(now - *before_at_), kCycle_s) : kCycle_s;
  velocity = limiter_.limitAcceleration(velocity, before_, elapsed_s);

  const double scan_age_s = watchdog_.last("scan") ? toSeconds(now - scan_stamp_) : 0.0;
  const GuardedTwist guarded = guard_.check(velocity, odometry.twist, scan_age_s, p_base);
  BaseCommand result = command;
  result.velocity = guarded.velocity;
  result.guard_share = guarded.share;
  if (guarded.share == 0.0) {
    result.reason = BaseCommand::Reason::kObstacle;
    result.text = "collision stop: the footprint would touch an obstacle";
  }
  return result;
}

std::optional<std::vector<Eigen::Vector2d>> BaseControl::obstaclesAt(Stamp now,
                                                                     const Pose2& odom_from_base) const {
  std::vector<Eigen::Vector2d> p_base;
  if (watchdog_.last("scan")) {
    const std::optional<Odometry> at_scan = odometry_.predictedAt(scan_stamp_);
    if (!at_scan) return std::nullopt;
    const Pose2 now_from_scan = odom_from_base.inverse() * at_scan->odom_from_base;
    for (const Eigen::Vector2d& p : p_base_at_scan_) p_base.push_back(now_from_scan * p);
  }
  for (const Eigen::Vector2d& p : near_.pointsAt(now, odom_from_base)) {
    if (guard_.clearance(p) > -params_.near.tolerance_m) p_base.push_back(p);
  }
  for (const Eigen::Vector2d& p : depth_.pointsAt(now, odom_from_base)) {
    if (guard_.clearance(p) > 0.0) p_base.push_back(p);  // inside: its place is known to a few centimetres
  }
  addNearest(now, odom_from_base, p_base);
  return p_base;
}

// The nearest obstacle where its velocity has brought it by now, and by one standard deviation nearer.
void BaseControl::addNearest(Stamp now, const Pose2& odom_from_base,
                             std::vector<Eigen::Vector2d>& p_base) const {
  constexpr double kStep_s = 0.05;
  constexpr double kOutward = 1.05;
  const bool fresh = !watchdog_.fault("obstacle/nearest", now) && refused_.count("obstacle/nearest") == 0;
  if (!fresh || !obstacle_.found) return;
  const Pose2 base_from_odom = odom_from_base.inverse();
  const double age_s = toSeconds(now - obstacle_.stamp);
  Eigen::Vector2d place = base_from_odom * obstacle_.p_odom;
  for (double t = 0.0; t < age_s && guard_.clearance(place) > 0.0; t += kStep_s) {
    place = base_from_odom * (obstacle_.p_odom + std::min(t + kStep_s, age_s) * obstacle_.velocity_mps);
  }
  const double distance_m = place.norm();
  if (distance_m < 1e-3) return;
  const double nearer = std::max(1.0 - obstacle_.sigma_m / distance_m, 1e-3);
  for (Eigen::Vector2d p : {place, Eigen::Vector2d(nearer * place)}) {
    // Not within the robot, however little is known of its distance: there it would hinder no motion.
    while (guard_.clearance(p) <= 0.0) p *= kOutward;
    p_base.push_back(p);
  }
}

bool BaseControl::isBlind(double v_mps) const {
  if (!watchdog_.last("scan")) return false;  // without a scanner: allowed by require_scan only
  return (v_mps > 0.0 && blind_.isBlindAhead()) || (v_mps < 0.0 && blind_.isBlindBehind());
}

}  // namespace frugal_nav
