#include <algorithm>
#include <cmath>
#include <limits>

#include <frugal_nav/control/path_follower.hpp>

namespace frugal_nav {

std::optional<PathPlace> placeOnPath(const Path2& path, const Eigen::Vector2d& p) {
  std::optional<PathPlace> best;
  double best_distance = std::numeric_limits<double>::infinity();
  double behind_m = 0.0;  // length of the path after the segment at hand
  for (std::size_t i = path.size(); i-- > 1;) {
    const Eigen::Vector2d begin = path[i - 1].position();
    const Eigen::Vector2d step = path[i].position() - begin;
    const double length = step.norm();
    if (length < 1e-9) continue;
    const Eigen::Vector2d along = step / length;
    const double s = std::clamp((p - begin).dot(along), 0.0, length);
    const Eigen::Vector2d aside = p - (begin + s * along);
    if (aside.norm() < best_distance) {
      best_distance = aside.norm();
      // Sideways from the segment's line, so that a point beyond the end is not "beside" the path.
      const double lateral = along.x() * (p - begin).y() - along.y() * (p - begin).x();
      best = PathPlace{lateral, behind_m + length - s, std::atan2(along.y(), along.x())};
    }
    behind_m += length;
  }
  return best;
}

PathFollower::PathFollower(const PathFollowerParams& params)
    : params_(params), pid_(params.lateral, params.max_turn_radps) {
  validate(params, "path follower");
}

void PathFollower::reset() {
  pid_.reset();
  last_.reset();
}

Twist2 PathFollower::command(const Path2& path, const Pose2& odom_from_base, Stamp now) {
  if (path.empty()) return {};
  Path2 line = path;
  if (path.size() == 1) line.insert(line.begin(), odom_from_base);
  const std::optional<PathPlace> here = placeOnPath(line, odom_from_base.position());
  if (!here || here->remaining_m <= params_.reached_m) return {};

  // Near the end the point ahead would lie beyond it: the error is taken at the end instead.
  const double ahead_m = std::min(params_.look_ahead_m, here->remaining_m);
  const std::optional<PathPlace> ahead = placeOnPath(line, odom_from_base * Eigen::Vector2d(ahead_m, 0.0));
  const double elapsed_s = last_ ? toSeconds(now - *last_) : 0.0;
  if (!last_ || now > *last_) last_ = now;
  const double turn = pid_.update(0.0, ahead->lateral_m, elapsed_s);

  const double off = angleBetween(odom_from_base.yaw_rad, here->heading_rad);
  const double fade = std::clamp(
      (params_.stop_from_rad - std::abs(off)) / (params_.stop_from_rad - params_.slow_from_rad), 0.0, 1.0);
  if (fade == 0.0) {
    return {0.0, std::clamp(params_.k_turn * off, -params_.max_turn_radps, params_.max_turn_radps)};
  }
  return {std::min(params_.cruise_mps, params_.k_end * here->remaining_m) * fade, turn};
}

}  // namespace frugal_nav
