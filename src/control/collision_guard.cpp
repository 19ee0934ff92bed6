#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include <frugal_nav/control/collision_guard.hpp>

namespace frugal_nav {
namespace {

// No point of the footprint moves farther than this between two checked poses, so that none is farther than
// half of it from a checked place: less than the default margins, slow_margin_m too.
constexpr double kStep_m = 0.015;
// Arcs tried where the commanded one is closed: each turns by so much more, to either side.
constexpr double kBend_radps = 0.06;
constexpr int kBends = 5;

Twist2 scaled(const Twist2& twist, double factor) { return {factor * twist.v_mps, factor * twist.w_radps}; }

}  // namespace

CollisionGuard::CollisionGuard(const CollisionGuardParams& params, const Polygon2& footprint)
    : params_(params) {
  validate(params, "collision guard");
  if (footprint.size() < 3) throw ConfigError("collision guard: the footprint needs three corners or more");
  for (std::size_t i = 0; i < footprint.size(); ++i) {
    const Eigen::Vector2d& corner = footprint[i];
    const Eigen::Vector2d along = (footprint[(i + 1) % footprint.size()] - corner).normalized();
    const Eigen::Vector2d outward(along.y(), -along.x());
    edges_.push_back({outward, outward.dot(corner)});
    circumradius_m_ = std::max(circumradius_m_, corner.norm());
  }
  for (const Eigen::Vector2d& corner : footprint) {
    if (!(clearance(corner) < 1e-6)) {
      throw ConfigError("collision guard: the footprint must be convex, its corners counter-clockwise");
    }
  }
}

double CollisionGuard::clearance(const Eigen::Vector2d& p_base) const {
  double largest = -std::numeric_limits<double>::infinity();
  for (const Edge& edge : edges_) largest = std::max(largest, edge.outward.dot(p_base) - edge.offset_m);
  return largest;
}

double CollisionGuard::wayOut_m(const Eigen::Vector2d& p_base, const Eigen::Vector2d& direction) const {
  double way_m = std::numeric_limits<double>::infinity();
  for (const Edge& edge : edges_) {
    const double inside_m = edge.offset_m - edge.outward.dot(p_base);
    if (inside_m < 0.0) return 0.0;
    const double toward = edge.outward.dot(direction);
    if (toward > 0.0) way_m = std::min(way_m, inside_m / toward);
  }
  return way_m;
}

GuardedTwist CollisionGuard::check(const Twist2& command, const Twist2& present, double scan_age_s,
                                   const std::vector<Eigen::Vector2d>& p_base) const {
  if (command.isZero()) return {};
  const double hold_s = params_.hold_s + std::max(scan_age_s, 0.0);
  const double reach_m = stoppingWay(command, present, hold_s).length_m + circumradius_m_ + params_.margin_m;
  const std::vector<Eigen::Vector2d> near = within(reach_m, p_base);
  const auto touchesNothing = [&](const Twist2& twist) {
    return isFree(stoppingWay(twist, present, hold_s), marginAt(twist), near);
  };
  for (const double share : {1.0, 0.75, 0.5, 0.25}) {
    const Twist2 twist = scaled(command, share);
    if (touchesNothing(twist)) return {twist, share};
  }
  if (command.w_radps != 0.0 && command.v_mps != 0.0) {
    for (const double share : {1.0, 0.25}) {
      const Twist2 turn{0.0, share * command.w_radps};
      if (touchesNothing(turn)) return {turn, share};
    }
  }
  for (int i = 1; command.v_mps != 0.0 && i <= kBends; ++i) {
    for (const double side : {1.0, -1.0}) {
      const Twist2 twist = bent(command, side * i * kBend_radps);
      if (touchesNothing(twist)) return {twist, twist.v_mps / command.v_mps};
    }
  }
  return {{}, 0.0};
}

/// A command at the speed of narrow passages on an arc that turns by so much more.
Twist2 CollisionGuard::bent(const Twist2& command, double turn_radps) const {
  const double slow_mps = 0.5 * params_.slow_mps;
  const double factor = std::min(1.0, slow_mps / std::abs(command.v_mps));
  return {factor * command.v_mps, factor * command.w_radps + turn_radps};
}

/// The air to keep at a velocity. A turn on the spot needs all of it: its corners sweep toward what lies
/// beside the laser, nearer than it can measure.
double CollisionGuard::marginAt(const Twist2& velocity) const {
  if (velocity.v_mps == 0.0) return params_.margin_m;
  const double fastest_mps = std::abs(velocity.v_mps) + std::abs(velocity.w_radps) * circumradius_m_;
  const double share =
      std::clamp((fastest_mps - params_.slow_mps) / (params_.full_mps - params_.slow_mps), 0.0, 1.0);
  return params_.slow_margin_m + share * (params_.margin_m - params_.slow_margin_m);
}

double CollisionGuard::freeDistance(const Twist2& velocity, double horizon_m,
                                    const std::vector<Eigen::Vector2d>& p_base) const {
  const double speed = std::abs(velocity.v_mps);
  if (speed == 0.0) return horizon_m;
  Way way;
  drive(way, velocity, velocity, horizon_m / speed);
  const std::vector<Eigen::Vector2d> near = within(horizon_m + circumradius_m_ + params_.margin_m, p_base);
  for (std::size_t i = 0; i < way.poses.size(); ++i) {
    if (keepsClear(way.poses[i], params_.margin_m, near)) continue;
    return horizon_m * static_cast<double>(i) / static_cast<double>(way.poses.size());
  }
  return horizon_m;
}

void CollisionGuard::drive(Way& way, const Twist2& begin, const Twist2& end, double duration_s) const {
  const double fastest = std::max(std::abs(begin.v_mps) + std::abs(begin.w_radps) * circumradius_m_,
                                  std::abs(end.v_mps) + std::abs(end.w_radps) * circumradius_m_);
  const int steps = static_cast<int>(std::ceil(fastest * duration_s / kStep_m));
  Pose2 pose = way.poses.empty() ? Pose2{} : way.poses.back();
  for (int i = 0; i < steps; ++i) {
    const double at = (static_cast<double>(i) + 0.5) / steps;
    const Twist2 twist{begin.v_mps + at * (end.v_mps - begin.v_mps),
                       begin.w_radps + at * (end.w_radps - begin.w_radps)};
    pose = pose * arcMotion(twist, duration_s / steps);
    way.poses.push_back(pose);
    way.length_m += std::abs(twist.v_mps) * duration_s / steps;
  }
}

CollisionGuard::Way CollisionGuard::stoppingWay(const Twist2& command, const Twist2& present,
                                                double hold_s) const {
  Way way;
  drive(way, present, present, params_.reaction_s);
  // It may reach a higher speed at once, but a lower one only by braking; so does its turn.
  const bool brakes = present.v_mps * (present.v_mps - command.v_mps) > 0.0;
  const double ramp_s = ramp(way, {brakes ? present.v_mps : command.v_mps, present.w_radps}, command);
  drive(way, command, command, std::max(hold_s - ramp_s, 0.0));
  ramp(way, command, {});
  return way;
}

/// From one velocity to another, speed and turn each by its own deceleration; how long it takes [s].
double CollisionGuard::ramp(Way& way, const Twist2& begin, const Twist2& end) const {
  const double speed_s = std::abs(end.v_mps - begin.v_mps) / params_.brake_mps2;
  const double turn_s = std::abs(end.w_radps - begin.w_radps) / params_.turn_brake_radps2;
  const double first_s = std::min(speed_s, turn_s);
  const double all_s = std::max(speed_s, turn_s);
  if (all_s == 0.0) return 0.0;
  const double speed_share = speed_s > 0.0 ? first_s / speed_s : 1.0;
  const double turn_share = turn_s > 0.0 ? first_s / turn_s : 1.0;
  const Twist2 between{begin.v_mps + speed_share * (end.v_mps - begin.v_mps),
                       begin.w_radps + turn_share * (end.w_radps - begin.w_radps)};
  drive(way, begin, between, first_s);
  drive(way, between, end, all_s - first_s);
  return all_s;
}

bool CollisionGuard::isFree(const Way& way, double margin_m,
                            const std::vector<Eigen::Vector2d>& p_base) const {
  return std::all_of(way.poses.begin(), way.poses.end(),
                     [&](const Pose2& pose) { return keepsClear(pose, margin_m, p_base); });
}

bool CollisionGuard::keepsClear(const Pose2& start_from_pose, double margin_m,
                                const std::vector<Eigen::Vector2d>& p_base) const {
  constexpr double kRounding_m = 1e-6;
  const double c = std::cos(start_from_pose.yaw_rad);
  const double s = std::sin(start_from_pose.yaw_rad);
  const double beyond_m = circumradius_m_ + margin_m;
  for (const Eigen::Vector2d& p : p_base) {
    const double dx = p.x() - start_from_pose.x_m;
    const double dy = p.y() - start_from_pose.y_m;
    if (dx * dx + dy * dy > beyond_m * beyond_m) continue;
    const double later_m = clearance({c * dx + s * dy, c * dy - s * dx});
    if (later_m < margin_m && later_m < clearance(p) - kRounding_m) return false;
  }
  return true;
}

std::vector<Eigen::Vector2d> CollisionGuard::within(double reach_m,
                                                    const std::vector<Eigen::Vector2d>& p_base) const {
  std::vector<Eigen::Vector2d> near;
  std::copy_if(p_base.begin(), p_base.end(), std::back_inserter(near),
               [reach_m](const Eigen::Vector2d& p) { return p.squaredNorm() < reach_m * reach_m; });
  return near;
}

}  // namespace frugal_nav
