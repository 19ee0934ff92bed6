#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include <frugal_nav/planning/moving_obstacles.hpp>

namespace frugal_nav {
namespace {

// Before anything that counts.
constexpr Duration kLongAgo = std::chrono::hours(1);

}  // namespace

ObstacleTrackerParams MovingObstaclesParams::scannerTracker() {
  ObstacleTrackerParams tracker;
  tracker.near_m = tracker.near_sigma_share = 0.0;
  tracker.max_range_m = 4.5;
  tracker.smallest_m = 0.05;
  tracker.largest_m = 1.1;
  tracker.sigma_m = 0.08;
  tracker.range_sigma_share = 0.01;
  tracker.bearing_sigma_rad = 0.01;
  tracker.acceleration_mps2 = 1.0;
  tracker.fastest_mps = 1.8;
  tracker.significance = 1.5;
  tracker.least_way_m = 0.2;
  tracker.largest_misfit = 4.0;
  tracker.unseen_s = 0.6;
  return tracker;
}

MovingObstacles::MovingObstacles(const MovingObstaclesParams& params)
    : params_(params), tracker_(params.tracker) {
  validate(params, "moving obstacles");
}

void MovingObstacles::reset() {
  tracker_.reset();
  moving_.clear();
  newcomers_.clear();
  since_.clear();
}

void MovingObstacles::update(const LaserScan& scan, const Pose2& odom_from_laser, const RollingGrid& grid) {
  const auto cells = static_cast<std::size_t>(grid.size()) * static_cast<std::size_t>(grid.size());
  if (since_.size() != cells) {
    since_.assign(cells, scan.stamp - kLongAgo);
    stood_.assign(cells, scan.stamp - kLongAgo);
  }
  now_ = scan.stamp;
  tracker_.update(newReturns(scan, odom_from_laser, grid), odom_from_laser,
                  [](const Eigen::Vector2d&) { return false; });
  moving_ = tracker_.moving();
  remember(scan, odom_from_laser, grid);
}

/// Notes since when cells have been occupied: a cell never seen before, or one at an edge that is hit now and
/// missed now, counts as having stood.
void MovingObstacles::remember(const LaserScan& scan, const Pose2& odom_from_laser, const RollingGrid& grid) {
  constexpr double kFlicker_s = 5.0;
  for (const Eigen::Vector2d& p : obstaclePoints(scan, odom_from_laser)) {
    const Cell cell = grid.cellOf(p);
    if (!grid.contains(cell)) continue;
    const auto place = static_cast<std::size_t>(grid.ringIndex(cell));
    if (grid.state(cell) == RollingGrid::State::kUnknown) {
      since_[place] = now_ - kLongAgo;
    } else if (grid.state(cell) == RollingGrid::State::kFree) {
      since_[place] = toSeconds(now_ - stood_[place]) < kFlicker_s ? now_ - kLongAgo : now_;
    }
    if (stands(place)) stood_[place] = now_;
  }
}

bool MovingObstacles::stands(std::size_t place) const {
  return toSeconds(now_ - since_[place]) >= params_.standing_s;
}

bool MovingObstacles::isMoving(const Eigen::Vector2d& p_odom) const {
  return std::any_of(moving_.begin(), moving_.end(), [&](const TrackedObstacle& track) {
    return (track.p_odom - p_odom).norm() < track.radius_m + params_.margin_m;
  });
}

bool MovingObstacles::isLeaving(const Eigen::Vector2d& p_odom, const Eigen::Vector2d& from_odom) const {
  return std::any_of(moving_.begin(), moving_.end(), [&](const TrackedObstacle& track) {
    return (track.p_odom - p_odom).norm() < track.radius_m + params_.margin_m &&
           (track.p_odom - from_odom).normalized().dot(track.velocity_mps) > 0.5 * track.velocity_mps.norm();
  });
}

/// Whether nothing stood near a place.
bool MovingObstacles::isNew(const Eigen::Vector2d& p_odom, double range_m, const RollingGrid& grid) const {
  const Cell middle = grid.cellOf(p_odom);
  if (!grid.contains(middle) || grid.state(middle) == RollingGrid::State::kUnknown) return false;
  const double near_m = params_.near_m + params_.near_share * range_m;
  const int reach = static_cast<int>(std::ceil(near_m / grid.cell_m()));
  for (int y = middle.y - reach; y <= middle.y + reach; ++y) {
    for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
      const Cell cell{x, y};
      if (grid.state(cell) != RollingGrid::State::kOccupied) continue;
      if (stands(static_cast<std::size_t>(grid.ringIndex(cell))) &&
          (grid.centerOf(cell) - p_odom).norm() <= near_m)
        return false;
    }
  }
  return true;
}

/// The scan without what stands, and with the gaps within an object closed.
LaserScan MovingObstacles::newReturns(const LaserScan& scan, const Pose2& odom_from_laser,
                                      const RollingGrid& grid) {
  newcomers_.clear();
  LaserScan found = scan;
  std::fill(found.ranges_m.begin(), found.ranges_m.end(), std::numeric_limits<float>::infinity());
  std::optional<std::size_t> last;
  Eigen::Vector2d last_odom = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (classify(scan, scan.ranges_m[i]) != Return::kHit) continue;
    const double range_m = scan.ranges_m[i];
    if (range_m > params_.tracker.max_range_m) continue;
    const Eigen::Vector2d p = odom_from_laser * *obstacleAt(scan, i);
    if (!isNew(p, range_m, grid)) continue;
    found.ranges_m[i] = scan.ranges_m[i];
    if (last && (p - last_odom).norm() <= params_.gap_m) {
      for (std::size_t k = *last + 1; k < i; ++k) {
        const float f = static_cast<float>(k - *last) / static_cast<float>(i - *last);
        found.ranges_m[k] = (1.0F - f) * found.ranges_m[*last] + f * scan.ranges_m[i];
      }
    }
    newcomers_.push_back(p);
    last = i;
    last_odom = p;
  }
  return found;
}

}  // namespace frugal_nav
