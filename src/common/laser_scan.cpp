#include <algorithm>
#include <limits>

#include <frugal_nav/common/laser_scan.hpp>

namespace frugal_nav {

std::optional<std::string> findFault(const LaserScan& scan) {
  if (scan.ranges_m.empty()) return "the scan is empty";
  if (!std::isfinite(scan.angle_min_rad) || !std::isfinite(scan.angle_increment_rad)) {
    return "angle_min or angle_increment is not finite";
  }
  if (scan.angle_increment_rad == 0.0 && scan.ranges_m.size() > 1) return "angle_increment is zero";
  // One beam of slack: drivers of 360-degree scanners often repeat the first direction at the end.
  const double swept = std::abs(scan.angle_increment_rad) * static_cast<double>(scan.ranges_m.size() - 1);
  if (swept > 2.0 * M_PI + std::abs(scan.angle_increment_rad)) return "the scan covers more than 360 degrees";
  if (!(scan.range_min_m >= 0.0) || !(scan.range_max_m > scan.range_min_m)) {
    return "range_min and range_max are not 0 <= min < max";
  }
  const bool any_known = std::any_of(scan.ranges_m.begin(), scan.ranges_m.end(), [&scan](float range) {
    return classify(scan, range) != Return::kUnknown;
  });
  if (!any_known) return "every range is NaN or beyond range_max";
  return std::nullopt;
}

std::optional<std::string> findFault(const LaserScan& scan, const ScanRules& rules) {
  if (const auto fault = findFault(scan)) return fault;
  const auto counts = [&](float range) {
    const Return kind = classify(scan, range);
    return kind == Return::kHit || kind == Return::kTooClose;
  };
  if (rules.require_return && std::none_of(scan.ranges_m.begin(), scan.ranges_m.end(), counts)) {
    return "it has no return at all: the laser is covered, or the place larger than its range (then set "
           "scan/require_return to false)";
  }
  return std::nullopt;
}

LaserScan readBy(const ScanRules& rules, LaserScan scan) {
  if (rules.inf_is_free) return scan;
  for (float& range : scan.ranges_m) {
    if (classify(scan, range) == Return::kFree) range = std::numeric_limits<float>::quiet_NaN();
  }
  return scan;
}

std::vector<Eigen::Vector2d> obstaclePoints(const LaserScan& scan, const Pose2& base_from_laser) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(scan.ranges_m.size());
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const Return kind = classify(scan, scan.ranges_m[i]);
    if (kind != Return::kHit && kind != Return::kTooClose) continue;
    const double range = kind == Return::kHit ? static_cast<double>(scan.ranges_m[i]) : scan.range_min_m;
    const double angle = scan.angleOf(i);
    points.push_back(base_from_laser * Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle)));
  }
  return points;
}

}  // namespace frugal_nav
