#include <algorithm>
#include <limits>

#include <frugal_nav/common/laser_scan.hpp>

namespace frugal_nav {
namespace {

// A million beams a turn: beyond that their numbers no longer fit.
constexpr double kFinestStep_rad = 2.0 * M_PI / 1e6;

/// Whether any range of a scan is of one of these kinds.
template <class... Kinds>
bool hasAny(const LaserScan& scan, Kinds... kinds) {
  return std::any_of(scan.ranges_m.begin(), scan.ranges_m.end(), [&](float range) {
    const Return kind = classify(scan, range);
    return ((kind == kinds) || ...);
  });
}

}  // namespace

std::optional<std::string> findFault(const LaserScan& scan) {
  if (scan.ranges_m.empty()) return "the scan is empty";
  if (!std::isfinite(scan.angle_min_rad) || !std::isfinite(scan.angle_increment_rad)) {
    return "angle_min or angle_increment is not finite";
  }
  const double step = std::abs(scan.angle_increment_rad);
  if (step == 0.0 && scan.ranges_m.size() > 1) return "angle_increment is zero";
  if (step != 0.0 && (step < kFinestStep_rad || step > 2.0 * M_PI))
    return "angle_increment is no angle between two beams";
  // One beam of slack: drivers of 360-degree scanners often repeat the first direction at the end.
  const double swept = step * static_cast<double>(scan.ranges_m.size() - 1);
  if (swept > 2.0 * M_PI + step) return "the scan covers more than 360 degrees";
  if (!(scan.range_min_m >= 0.0) || !(scan.range_max_m > scan.range_min_m)) {
    return "range_min and range_max are not 0 <= min < max";
  }
  if (hasAny(scan, Return::kHit, Return::kFree)) return std::nullopt;
  if (hasAny(scan, Return::kTooClose)) {
    return "every range is below range_min: the laser is covered, or its driver sends zeros for failed "
           "echoes";
  }
  return "every range is NaN or beyond range_max";
}

std::optional<std::string> findFault(const LaserScan& scan, const ScanRules& rules) {
  if (const auto fault = findFault(scan)) return fault;
  if (rules.require_return && !hasAny(scan, Return::kHit, Return::kTooClose)) {
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

std::optional<Eigen::Vector2d> obstacleAt(const LaserScan& scan, std::size_t beam) {
  const Return kind = classify(scan, scan.ranges_m[beam]);
  if (kind != Return::kHit && kind != Return::kTooClose) return std::nullopt;
  const double range = kind == Return::kHit ? static_cast<double>(scan.ranges_m[beam]) : scan.range_min_m;
  const double angle = scan.angleOf(beam);
  return Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle));
}

std::vector<Eigen::Vector2d> obstaclePoints(const LaserScan& scan, const Pose2& base_from_laser) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(scan.ranges_m.size());
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (const auto p_laser = obstacleAt(scan, i)) points.push_back(base_from_laser * *p_laser);
  }
  return points;
}

}  // namespace frugal_nav
