#include <algorithm>
#include <cmath>

#include <frugal_nav/planning/corridor.hpp>

namespace frugal_nav {

bool isFree(const Corridor& corridor, const std::vector<Eigen::Vector2d>& obstacles_base) {
  const double length = corridor.to_base.norm();
  if (length < 1e-9) return true;
  const Eigen::Vector2d along = corridor.to_base / length;
  return std::none_of(obstacles_base.begin(), obstacles_base.end(), [&](const Eigen::Vector2d& p) {
    const double ahead = p.dot(along);
    const double aside = std::abs(along.x() * p.y() - along.y() * p.x());
    return ahead > 0.0 && ahead <= length + corridor.beyond_m && aside < corridor.half_width_m;
  });
}

}  // namespace frugal_nav
