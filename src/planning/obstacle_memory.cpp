#include <algorithm>
#include <cmath>

#include <frugal_nav/planning/obstacle_memory.hpp>

namespace frugal_nav {
namespace {

// Hits this much beyond a moving object's radius are its own: limbs, and the noise of its middle.
constexpr double kMovingMargin_m = 0.20;
// No guess is nearer than the truth by more than this share of itself.
constexpr double kMostGuess = 0.9;
// What it left in the memory before it was known to move reaches about this far beyond its radius.
constexpr double kTrailMargin_m = 0.15;

}  // namespace

ObstacleMemory::ObstacleMemory(const ObstacleMemoryParams& params)
    : params_(params), grid_(params.grid), tracker_(params.tracker) {
  validate(params, "obstacle memory");
}

void ObstacleMemory::setParams(const ObstacleMemoryParams& params) {
  validate(params, "obstacle memory");
  params_ = params;
  grid_.setParams(params.grid);
  tracker_.setParams(params.tracker);
}

void ObstacleMemory::reset() {
  grid_.reset();
  tracker_.reset();
  moving_.clear();
}

void ObstacleMemory::insert(const LaserScan& scan, const NearestObstacle& obstacle,
                            const Pose2& odom_from_base,
                            const std::optional<Eigen::Vector2d>& p_odom_person) {
  follow(scan, obstacle, odom_from_base, p_odom_person);
  const Eigen::Vector2d robot = odom_from_base.position();
  grid_.moveTo(robot);
  grid_.begin(scan.stamp);
  for (const TrackedObstacle& moved : moving_) {
    for (const Eigen::Vector2d& p : moved.trail)
      grid_.erase(p, moved.radius_m + kTrailMargin_m, params_.standing_certainty);
  }
  const double longest_m = std::min(params_.grid.max_range_m, scan.range_max_m);
  const auto endOf = [&](std::size_t beam, double range_m) {
    const double angle = scan.angleOf(beam);
    return odom_from_base * Eigen::Vector2d(range_m * std::cos(angle), range_m * std::sin(angle));
  };
  std::vector<Eigen::Vector2d> hits;  // marked after all were judged: they must not vouch for each other
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const Return kind = classify(scan, scan.ranges_m[i]);
    if (kind != Return::kHit && kind != Return::kTooClose) continue;
    const double range_m = kind == Return::kHit ? scan.ranges_m[i] : scan.range_min_m;
    const Eigen::Vector2d p = endOf(i, range_m);
    if (range_m > longest_m || isPerson(p, robot, p_odom_person) || isMoving(p)) continue;
    const bool is_on_obstacle = grid_.state(grid_.cellOf(p)) == RollingGrid::State::kOccupied;
    if (is_on_obstacle || !isKnown(robot, p)) hits.push_back(p);
  }
  const bool has_nearest = obstacle.found && !isPerson(obstacle.p_odom, robot, p_odom_person) &&
                           !isMoving(obstacle.p_odom) && !isKnown(robot, obstacle.p_odom);
  for (const Eigen::Vector2d& p : hits) grid_.mark(p);
  if (has_nearest) markNearest(obstacle);
  const std::vector<double> clear_m = clearLengths(scan, longest_m);
  for (std::size_t i = 0; i < clear_m.size(); ++i) {
    const double near_m = std::min(clear_m[i], params_.clear_from_m);
    const double below_m = std::min(near_m, params_.clear_doubtful_from_m);
    if (near_m > 0.0) grid_.clearDoubtful(robot, endOf(i, below_m), 0);
    if (near_m > below_m)
      grid_.clearDoubtful(endOf(i, below_m), endOf(i, near_m), params_.standing_certainty);
    if (clear_m[i] > near_m) grid_.clear(endOf(i, near_m), endOf(i, clear_m[i]), true);
  }
}

/// How far each ray shows free space: to a standard deviation before its hit, and no farther than a hit
/// beside it that is less than a cell away, lest rays that graze an edge wear it off. A hit so near that its
/// foot is out of view shows none: its distance is a guess.
std::vector<double> ObstacleMemory::clearLengths(const LaserScan& scan, double longest_m) const {
  const std::size_t beams = scan.ranges_m.size();
  std::vector<double> lengths(beams, 0.0);
  std::vector<double> sure(beams, longest_m);
  for (std::size_t i = 0; i < beams; ++i) {
    const Return kind = classify(scan, scan.ranges_m[i]);
    if (kind == Return::kHit)
      sure[i] = scan.ranges_m[i] * (1.0 - params_.sigma_share) - params_.sigma_m;
    else if (kind == Return::kTooClose)
      sure[i] = 0.0;
    const bool is_guess = kind == Return::kHit && scan.ranges_m[i] < static_cast<float>(params_.clear_from_m);
    if (!is_guess && (kind == Return::kHit || kind == Return::kFree))
      lengths[i] = std::min(sure[i], longest_m);
  }
  for (std::size_t i = 0; i < beams; ++i) {
    if (classify(scan, scan.ranges_m[i]) != Return::kHit) continue;
    const double spread = params_.grid.cell_m / (scan.ranges_m[i] * std::abs(scan.angle_increment_rad));
    const auto reach = static_cast<std::size_t>(std::min(spread, static_cast<double>(beams)));
    const std::size_t last = std::min(i + reach, beams - 1);
    for (std::size_t k = i - std::min(reach, i); k <= last; ++k) lengths[k] = std::min(lengths[k], sure[i]);
  }
  return lengths;
}

void ObstacleMemory::follow(const LaserScan& scan, const NearestObstacle& obstacle,
                            const Pose2& odom_from_base,
                            const std::optional<Eigen::Vector2d>& p_odom_person) {
  const Eigen::Vector2d robot = odom_from_base.position();
  tracker_.update(scan, odom_from_base,
                  [&](const Eigen::Vector2d& p) { return isPerson(p, robot, p_odom_person); });
  moving_ = tracker_.moving();
  moving_.erase(std::remove_if(moving_.begin(), moving_.end(),
                               [this](const TrackedObstacle& track) { return isStanding(track.p_odom); }),
                moving_.end());
  const double speed_mps = obstacle.velocity_mps.norm();
  if (!obstacle.found || speed_mps < params_.tracker.slowest_mps || isMoving(obstacle.p_odom) ||
      isPerson(obstacle.p_odom, robot, p_odom_person) || isStanding(obstacle.p_odom))
    return;
  TrackedObstacle nearest;  // known to move by whoever found it
  nearest.p_odom = obstacle.p_odom;
  nearest.velocity_mps = obstacle.velocity_mps;
  nearest.radius_m = 0.25;
  nearest.stamp = nearest.last_seen = scan.stamp;
  nearest.moving = true;
  nearest.trail = {obstacle.p_odom};
  moving_.push_back(nearest);
}

/// Whether a hit so near that no foot is in view is of a thing whose place is known better, from when its
/// foot was: an obstacle on the same ray, about as far.
bool ObstacleMemory::isKnown(const Eigen::Vector2d& robot, const Eigen::Vector2d& p_odom) const {
  const double range_m = (p_odom - robot).norm();
  if (range_m > params_.clear_from_m) return false;
  const Eigen::Vector2d along = (p_odom - robot).normalized();
  const double to_m = range_m + std::min(params_.near_beyond_m, kMostGuess * range_m);
  for (double r = (1.0 - params_.near_share) * range_m; r <= to_m; r += 0.5 * grid_.cell_m()) {
    if (grid_.state(grid_.cellOf(robot + r * along)) == RollingGrid::State::kOccupied) return true;
  }
  return false;
}

void ObstacleMemory::markNearest(const NearestObstacle& obstacle) {
  const double sigma_m = std::isfinite(obstacle.sigma_m) ? obstacle.sigma_m : params_.largest_sigma_m;
  grid_.mark(obstacle.p_odom);
  const double radius_m = std::min(sigma_m, params_.largest_sigma_m);
  const double cell_m = grid_.cell_m();
  for (double y = -radius_m; y <= radius_m; y += cell_m) {
    for (double x = -radius_m; x <= radius_m; x += cell_m) {
      if (x * x + y * y <= radius_m * radius_m) grid_.mark(obstacle.p_odom + Eigen::Vector2d(x, y));
    }
  }
}

bool ObstacleMemory::isPerson(const Eigen::Vector2d& p_odom, const Eigen::Vector2d& robot,
                              const std::optional<Eigen::Vector2d>& p_odom_person) const {
  if (!p_odom_person) return false;
  const Eigen::Vector2d way = *p_odom_person - robot;
  const double distance_m = way.norm();
  const Eigen::Vector2d off = p_odom - *p_odom_person;
  if (distance_m < 1e-6) return off.norm() < params_.person_radius_m;
  const Eigen::Vector2d along = way / distance_m;
  const double ahead_m = off.dot(along);
  const double aside_m = std::abs(along.x() * off.y() - along.y() * off.x());
  return aside_m < params_.person_radius_m &&
         std::abs(ahead_m) < params_.person_radius_m + params_.person_range_share * distance_m;
}

bool ObstacleMemory::isMoving(const Eigen::Vector2d& p_odom) const {
  return std::any_of(moving_.begin(), moving_.end(), [&](const TrackedObstacle& track) {
    return (track.p_odom - p_odom).norm() < track.radius_m + kMovingMargin_m;
  });
}

bool ObstacleMemory::isStanding(const Eigen::Vector2d& p_odom) const {
  return grid_.certainty(grid_.cellOf(p_odom)) > params_.standing_certainty;
}

}  // namespace frugal_nav
