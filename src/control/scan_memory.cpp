#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <frugal_nav/control/scan_memory.hpp>

namespace frugal_nav {

void ScanMemory::setParams(const ScanMemoryParams& params) {
  validate(params, "scan memory");
  params_ = params;
}

void ScanMemory::add(const LaserScan& scan, const Pose2& base_from_sensor, const Pose2& odom_from_base) {
  const auto cellOf = [this](const Eigen::Vector2d& p) {
    return std::make_pair(std::floor(p.x() / params_.cell_m), std::floor(p.y() / params_.cell_m));
  };
  std::vector<Point> fresh;
  std::set<std::pair<double, double>> taken;
  const auto keep = [&](const Point& point) {
    if (taken.insert(cellOf(point.p_odom)).second) fresh.push_back(point);
  };
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (classify(scan, scan.ranges_m[i]) != Return::kHit) continue;
    const Eigen::Vector2d p_base = base_from_sensor * *obstacleAt(scan, i);
    const Eigen::Vector2d p_odom = odom_from_base * p_base;
    if (p_base.norm() <= params_.range_m) keep({p_odom, scan.stamp, isConfirmed(p_odom)});
  }
  const Pose2 sensor_from_odom = (odom_from_base * base_from_sensor).inverse();
  const Duration span = fromSeconds(params_.memory_s);
  for (const Point& point : points_) {
    if (scan.stamp - point.stamp > span) continue;
    const View view = viewOf(sensor_from_odom * point.p_odom, point.confirmed, scan);
    if (view == View::kThrough) continue;
    keep({point.p_odom, view == View::kTooClose ? scan.stamp : point.stamp, point.confirmed});
  }
  points_ = std::move(fresh);
}

bool ScanMemory::knows(const LaserScan& scan, std::size_t beam, const Pose2& odom_from_sensor) const {
  const Pose2 sensor_from_odom = odom_from_sensor.inverse();
  const double angle = scan.angleOf(beam);
  return std::any_of(points_.begin(), points_.end(), [&](const Point& point) {
    const Eigen::Vector2d p = sensor_from_odom * point.p_odom;
    const double range_m = p.norm();
    if (range_m > scan.range_min_m + params_.tolerance_m) return false;
    const double beside_rad = std::asin(std::min(params_.tolerance_m / std::max(range_m, 1e-3), 1.0));
    return std::abs(angleBetween(angle, std::atan2(p.y(), p.x()))) <= beside_rad;
  });
}

/// Whether an earlier scan saw something about there: so near that it is the same thing. Nothing rests on it
/// for a sensor that sees all that is near.
bool ScanMemory::isConfirmed(const Eigen::Vector2d& p_odom) const {
  constexpr double kSame_m = 0.15;
  if (params_.below_view_m == 0.0) return false;
  return std::any_of(points_.begin(), points_.end(), [&](const Point& point) {
    return (point.p_odom - p_odom).squaredNorm() < kSame_m * kSame_m;
  });
}

ScanMemory::View ScanMemory::viewOf(const Eigen::Vector2d& p_sensor, bool confirmed,
                                    const LaserScan& scan) const {
  const double range_m = p_sensor.norm();
  if ((range_m < params_.below_view_m && confirmed) || scan.angle_increment_rad == 0.0) return View::kHidden;
  const double step_rad = std::abs(scan.angle_increment_rad);
  const int turn = static_cast<int>(std::lround(2.0 * M_PI / step_rad));
  const double bearing_rad = std::atan2(p_sensor.y(), p_sensor.x());
  const int centre =
      static_cast<int>(std::lround(wrapAngle(bearing_rad - scan.angle_min_rad) / scan.angle_increment_rad));
  const double beside_rad = std::asin(std::min(params_.tolerance_m / std::max(range_m, 1e-3), 1.0));
  const int beside = static_cast<int>(beside_rad / step_rad);
  View view = View::kThrough;
  for (int i = -beside; i <= beside; ++i) {
    const auto beam = static_cast<std::size_t>(((centre + i) % turn + turn) % turn);
    if (beam >= scan.ranges_m.size()) return View::kHidden;
    const float seen_m = scan.ranges_m[beam];
    const Return kind = classify(scan, seen_m);
    if (kind == Return::kTooClose) return View::kTooClose;
    const bool is_before = i == 0 && kind == Return::kHit && seen_m <= range_m - params_.tolerance_m;
    if (kind == Return::kUnknown || is_before) view = View::kHidden;
  }
  return view;
}

std::vector<Eigen::Vector2d> ScanMemory::pointsAt(Stamp now, const Pose2& odom_from_base) const {
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
