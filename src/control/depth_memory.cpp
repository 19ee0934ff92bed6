#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <frugal_nav/control/depth_memory.hpp>

namespace frugal_nav {

void DepthMemory::setParams(const DepthMemoryParams& params) {
  validate(params, "depth memory");
  params_ = params;
}

void DepthMemory::add(const LaserScan& scan, const Pose2& odom_from_base) {
  const auto cellOf = [this](const Eigen::Vector2d& p) {
    return std::make_pair(std::floor(p.x() / params_.cell_m), std::floor(p.y() / params_.cell_m));
  };
  std::vector<Point> fresh;
  std::set<std::pair<double, double>> taken;
  for (const Eigen::Vector2d& p_base : obstaclePoints(scan, {})) {
    if (p_base.norm() > params_.range_m) continue;
    const Eigen::Vector2d p_odom = odom_from_base * p_base;
    if (taken.insert(cellOf(p_odom)).second) fresh.push_back({p_odom, scan.stamp});
  }
  const Pose2 base_from_odom = odom_from_base.inverse();
  const Duration span = fromSeconds(params_.memory_s);
  for (const Point& point : points_) {
    if (scan.stamp - point.stamp > span || isSeenThrough(base_from_odom * point.p_odom, scan)) continue;
    if (taken.insert(cellOf(point.p_odom)).second) fresh.push_back(point);
  }
  points_ = std::move(fresh);
}

bool DepthMemory::isSeenThrough(const Eigen::Vector2d& p_base, const LaserScan& scan) const {
  const double range_m = p_base.norm();
  if (range_m < params_.below_view_m) return false;
  const double turn_rad = wrapAngle(std::atan2(p_base.y(), p_base.x()) - scan.angle_min_rad);
  const double beam = std::round(turn_rad / scan.angle_increment_rad);
  if (!(beam >= 0.0 && beam < static_cast<double>(scan.ranges_m.size()))) return false;
  const float seen_m = scan.ranges_m[static_cast<std::size_t>(beam)];
  const Return kind = classify(scan, seen_m);
  return kind == Return::kFree || (kind == Return::kHit && static_cast<double>(seen_m) > range_m);
}

std::vector<Eigen::Vector2d> DepthMemory::pointsAt(Stamp now, const Pose2& odom_from_base) const {
  const Pose2 base_from_odom = odom_from_base.inverse();
  const Duration span = fromSeconds(params_.memory_s);
  std::vector<Eigen::Vector2d> p_base;
  p_base.reserve(points_.size());
  for (const Point& point : points_) {
    if (now - point.stamp <= span) p_base.push_back(base_from_odom * point.p_odom);
  }
  return p_base;
}

}  // namespace frugal_nav
