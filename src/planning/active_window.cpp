#include <algorithm>
#include <cmath>

#include <frugal_nav/planning/active_window.hpp>

namespace frugal_nav {

ActiveWindow::ActiveWindow(const RollingGridParams& params) : params_(params), grid_(params) {
  hits_.resize(static_cast<std::size_t>(grid_.size()) * static_cast<std::size_t>(grid_.size()));
}

std::size_t ActiveWindow::placeOf(Cell cell) const { return static_cast<std::size_t>(grid_.ringIndex(cell)); }

void ActiveWindow::update(const LaserScan& scan, const Pose2& odom_from_laser,
                          const Eigen::Vector2d& p_odom_robot) {
  grid_.moveTo(p_odom_robot);
  grid_.insert(scan, odom_from_laser);
  for (const Eigen::Vector2d& p : obstaclePoints(scan, odom_from_laser)) {
    const Cell cell = grid_.cellOf(p);
    if (grid_.contains(cell)) hits_[placeOf(cell)] = p.cast<float>();
  }
}

void ActiveWindow::reset() { grid_.reset(); }

void ActiveWindow::setParams(const RollingGridParams& params) {
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
