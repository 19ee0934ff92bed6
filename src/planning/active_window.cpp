#include <algorithm>
#include <limits>

#include <frugal_nav/planning/active_window.hpp>

namespace frugal_nav {
namespace {

// What a thing left in the grid before it was known to move reaches about this far beyond its radius.
constexpr double kBeside_m = 0.10;
// Beams that say nothing are followed from outside the body to where a robot stops in time.
constexpr double kUnseenFrom_m = 0.3;
constexpr double kUnseenTo_m = 1.0;

}  // namespace

ActiveWindow::ActiveWindow(const RollingGridParams& params, const MovingObstaclesParams& moving)
    : params_(params), grid_(params), moving_(moving) {
  hits_.resize(static_cast<std::size_t>(grid_.size()) * static_cast<std::size_t>(grid_.size()));
}

std::size_t ActiveWindow::placeOf(Cell cell) const { return static_cast<std::size_t>(grid_.ringIndex(cell)); }

void ActiveWindow::update(const LaserScan& scan, const Pose2& odom_from_laser,
                          const Eigen::Vector2d& p_odom_robot) {
  grid_.moveTo(p_odom_robot);
  moving_.update(scan, odom_from_laser, grid_);
  for (const TrackedObstacle& moved : moving_.moving()) {
    for (const Eigen::Vector2d& p : moved.trail)
      grid_.erase(p, moved.radius_m + kBeside_m, params_.max_certainty);
  }
  const LaserScan standing = takeMovingOut(scan, odom_from_laser);
  grid_.insert(standing, odom_from_laser);
  for (const Eigen::Vector2d& p : obstaclePoints(standing, odom_from_laser)) {
    const Cell cell = grid_.cellOf(p);
    if (grid_.contains(cell)) hits_[placeOf(cell)] = p.cast<float>();
  }
  findUnseen(scan, odom_from_laser);
}

/// Of each beam that says nothing, the first place that is not known from before.
void ActiveWindow::findUnseen(const LaserScan& scan, const Pose2& odom_from_laser) {
  unseen_.clear();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (classify(scan, scan.ranges_m[i]) != Return::kUnknown) continue;
    const double angle = scan.angleOf(i);
    for (double range_m = kUnseenFrom_m; range_m <= kUnseenTo_m; range_m += params_.cell_m) {
      const Eigen::Vector2d p =
          odom_from_laser * Eigen::Vector2d(range_m * std::cos(angle), range_m * std::sin(angle));
      const RollingGrid::State state = grid_.state(grid_.cellOf(p));
      if (state == RollingGrid::State::kUnknown) unseen_.push_back(p);
      if (state != RollingGrid::State::kFree) break;
    }
  }
}

/// The scan without the returns of what moves, which say nothing then.
LaserScan ActiveWindow::takeMovingOut(const LaserScan& scan, const Pose2& odom_from_laser) {
  LaserScan standing = scan;
  moving_hits_.clear();
  if (moving_.moving().empty()) return standing;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (classify(scan, scan.ranges_m[i]) != Return::kHit) continue;
    const Eigen::Vector2d p = odom_from_laser * *obstacleAt(scan, i);
    if (!moving_.isMoving(p)) continue;
    moving_hits_.push_back(p);
    standing.ranges_m[i] = std::numeric_limits<float>::quiet_NaN();
  }
  return standing;
}

void ActiveWindow::reset() {
  grid_.reset();
  moving_.reset();
  moving_hits_.clear();
  unseen_.clear();
}

void ActiveWindow::setParams(const RollingGridParams& params, const MovingObstaclesParams& moving) {
  moving_ = MovingObstacles(moving);
  moving_hits_.clear();
  unseen_.clear();
  grid_.setParams(params);
  params_ = params;
  hits_.resize(static_cast<std::size_t>(grid_.size()) * static_cast<std::size_t>(grid_.size()));
}

std::vector<WindowPoint> ActiveWindow::pointsWithin(const Eigen::Vector2d& p_odom, double radius_m) const {
  std::vector<WindowPoint> points;
  const Cell low = grid_.cellOf(p_odom - Eigen::Vector2d::Constant(radius_m));
  const Cell high = grid_.cellOf(p_odom + Eigen::Vector2d::Constant(radius_m));
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) {
      const int certainty = grid_.certainty({x, y});
      if (certainty == 0) continue;
      const Eigen::Vector2d p = hits_[placeOf({x, y})].cast<double>();
      if ((p - p_odom).squaredNorm() > radius_m * radius_m) continue;
      points.push_back({p, static_cast<double>(certainty) / params_.max_certainty});
    }
  }
  for (const auto* places : {&moving_hits_, &unseen_}) {
    for (const Eigen::Vector2d& p : *places) {
      if ((p - p_odom).squaredNorm() <= radius_m * radius_m) points.push_back({p, 1.0});
    }
  }
  return points;
}

std::vector<Eigen::Vector2d> placesFrom(const Pose2& odom_from_base, const std::vector<WindowPoint>& points) {
  const Pose2 base_from_odom = odom_from_base.inverse();
  std::vector<Eigen::Vector2d> p_base;
  p_base.reserve(points.size());
  for (const WindowPoint& point : points) p_base.push_back(base_from_odom * point.p_odom);
  return p_base;
}

}  // namespace frugal_nav
