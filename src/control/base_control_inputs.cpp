#include <cmath>
#include <limits>

#include <frugal_nav/control/base_control.hpp>

// What comes in: every input is checked, stamped and kept here; base_control.cpp decides with it.

namespace frugal_nav {
namespace {

std::optional<std::string> inputFault(const Twist2& velocity, const PlausibleCommands& plausible) {
  if (!velocity.isFinite()) return "the velocity is not finite";
  if (std::abs(velocity.v_mps) > plausible.max_v_mps) return "the speed is out of range";
  if (std::abs(velocity.w_radps) > plausible.max_w_radps) return "the turn rate is out of range";
  return std::nullopt;
}

std::optional<std::string> inputFault(const Pose2& target, const OdometryBuffer& odometry,
                                      const PlausibleCommands& plausible) {
  if (!target.isFinite()) return "the target is not finite";
  if (odometry.empty()) return std::nullopt;  // cannot be driven to before there is odometry
  const double away_m = distance(odometry.newest().odom_from_base, target);
  if (away_m > plausible.max_target_distance_m) return "the target is out of range";
  return std::nullopt;
}

std::optional<std::string> inputFault(const MotionCommand& command, const OdometryBuffer& odometry,
                                      const PlausibleCommands& plausible) {
  switch (command.holds) {
    case MotionCommand::Holds::kNothing:
      return std::nullopt;
    case MotionCommand::Holds::kVelocity:
      return inputFault(command.velocity, plausible);
    case MotionCommand::Holds::kTarget:
      return inputFault(command.odom_from_target, odometry, plausible);
  }
  return "it holds an unknown thing";
}

std::optional<std::string> inputFault(const Odometry& odometry, const PlausibleCommands& plausible) {
  if (!odometry.odom_from_base.isFinite()) return "its pose is not finite";
  return inputFault(odometry.twist, plausible);
}

std::optional<std::string> inputFault(const NearestObstacle& obstacle) {
  if (!obstacle.found) {
    return obstacle.reason.empty() ? std::nullopt : std::optional<std::string>(obstacle.reason);
  }
  if (!obstacle.p_odom.allFinite() || !obstacle.velocity_mps.allFinite()) return "it is not finite";
  if (!(obstacle.sigma_m >= 0.0)) return "its standard deviation is not a number of metres";
  return std::nullopt;
}

/// As findFault(), but a scan that knows nothing is sound: the image's use is obstacle/nearest's to tell.
std::optional<std::string> depthFault(LaserScan scan) {
  if (scan.ranges_m.empty()) return "the scan is empty";
  scan.ranges_m.front() = std::numeric_limits<float>::infinity();
  return findFault(scan);
}

}  // namespace

bool BaseControl::accept(const std::string& input, Stamp stamp, const std::optional<std::string>& fault) {
  if (fault) {
    refuse(input, *fault);
    return false;
  }
  if (!watchdog_.feed(input, stamp)) {
    reset();
    time_jumped_ = true;
    ++time_jumps_;
    watchdog_.feed(input, stamp);
  }
  refused_.erase(input);
  return true;
}

void BaseControl::refuse(const std::string& input, const std::string& why) {
  if (input == "scan") has_scanner_ = true;  // there is one, though nobody can tell what it sees
  refused_[input] = input + " is refused: " + why;
}

std::string BaseControl::refusal(const std::string& input) const {
  const auto found = refused_.find(input);
  return found == refused_.end() ? "" : found->second;
}

bool BaseControl::setMission(const MissionStatus& status) {
  if (!accept("mission/state", status.stamp, std::nullopt)) return false;
  const bool new_goal = status.goal_number != mission_.goal_number;
  if (new_goal || status.mode != mission_.mode) follower_.reset();
  if (new_goal) goal_since_ = status.stamp;
  mission_ = status;
  return true;
}

bool BaseControl::setOdometry(const Odometry& odometry) {
  if (!accept("odom", odometry.stamp, inputFault(odometry, params_.plausible))) return false;
  odometry_.add(odometry);
  return true;
}

bool BaseControl::setScan(const LaserScan& as_sent, const Pose2& base_from_laser) {
  has_scanner_ = true;
  const LaserScan scan = readBy(params_.scan, as_sent);
  if (!accept("scan", scan.stamp, findFault(scan, params_.scan))) return false;
  scan_stamp_ = scan.stamp;
  const LaserScan of_others = withoutOwnParts(scan, base_from_laser);
  const std::optional<Odometry> odometry = odometry_.predictedAt(scan.stamp);
  if (odometry) near_.add(of_others, base_from_laser, odometry->odom_from_base);
  p_base_at_scan_.clear();
  for (std::size_t i = 0; i < of_others.ranges_m.size(); ++i) {
    const auto p_laser = obstacleAt(of_others, i);
    if (!p_laser) continue;
    const bool is_guess =
        classify(of_others, of_others.ranges_m[i]) == Return::kTooClose &&
        !(odometry && near_.knows(of_others, i, odometry->odom_from_base * base_from_laser));
    p_base_at_scan_.push_back(is_guess ? nearestOn(of_others, i, base_from_laser)
                                       : base_from_laser * *p_laser);
  }
  blind_.add(scan, base_from_laser);
  return true;
}

/// A scan whose returns from within the footprint, which are parts of the robot itself, say nothing.
LaserScan BaseControl::withoutOwnParts(LaserScan scan, const Pose2& base_from_laser) const {
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const auto p_laser = obstacleAt(scan, i);
    // A little within it is noise: something touches the robot.
    if (p_laser && guard_.clearance(base_from_laser * *p_laser) < -params_.near.tolerance_m) {
      scan.ranges_m[i] = std::numeric_limits<float>::quiet_NaN();
    }
  }
  return scan;
}

/// Where on a beam the nearest thing could be that is too near to measure and was never seen from farther
/// off: where it leaves the footprint, so that nothing moves toward it.
Eigen::Vector2d BaseControl::nearestOn(const LaserScan& scan, std::size_t beam,
                                       const Pose2& base_from_laser) const {
  const double angle = base_from_laser.yaw_rad + scan.angleOf(beam);
  const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
  const Eigen::Vector2d from = base_from_laser.position();
  return from + std::min(guard_.wayOut_m(from, direction), scan.range_min_m) * direction;
}

bool BaseControl::setLocalCommand(const MotionCommand& command) {
  if (!accept("avoidance/command", command.stamp, inputFault(command, odometry_, params_.plausible)))
    return false;
  local_command_ = command;
  return true;
}

bool BaseControl::setPath(const Path2& path, Stamp stamp) {
  std::optional<std::string> fault;
  for (const Pose2& pose : path) {
    if (!fault) fault = inputFault(pose, odometry_, params_.plausible);
  }
  if (!accept("path", stamp, fault)) return false;
  path_ = path;
  return true;
}

bool BaseControl::setObstacle(const NearestObstacle& obstacle) {
  if (!accept("obstacle/nearest", obstacle.stamp, inputFault(obstacle))) return false;
  obstacle_ = obstacle;
  return true;
}

bool BaseControl::setDepthScan(const LaserScan& scan) {
  has_depth_ = true;
  if (!accept("depth/scan", scan.stamp, depthFault(scan))) return false;
  const std::optional<Odometry> odometry = odometry_.predictedAt(scan.stamp);
  if (odometry) depth_.add(scan, {}, odometry->odom_from_base);
  return true;
}

bool BaseControl::setMissionCommand(const Twist2& velocity, Stamp stamp) {
  if (!accept("mission/command", stamp, inputFault(velocity, params_.plausible))) return false;
  mission_command_ = velocity;
  return true;
}

bool BaseControl::setManualCommand(const Twist2& velocity, Stamp stamp) {
  if (!accept("cmd_vel_in", stamp, inputFault(velocity, params_.plausible))) return false;
  manual_command_ = velocity;
  return true;
}

}  // namespace frugal_nav
