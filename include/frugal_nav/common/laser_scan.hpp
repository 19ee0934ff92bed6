#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// One planar laser scan in the sensor's frame. Ranges follow REP-117.
struct LaserScan {
  Stamp stamp{};
  double angle_min_rad = 0.0;
  double angle_increment_rad = 0.0;
  double range_min_m = 0.0;
  double range_max_m = 0.0;
  std::vector<float> ranges_m;

  double angleOf(std::size_t beam) const {
    return angle_min_rad + angle_increment_rad * static_cast<double>(beam);
  }
};

/// What one range of a scan says (REP-117).
enum class Return {
  kHit,       ///< an obstacle at that range
  kFree,      ///< +inf: nothing within range_max
  kTooClose,  ///< -inf, or below range_min: an obstacle nearer than the sensor can measure
  kUnknown,   ///< NaN, or above range_max
};

/// Classifies one range of a scan by REP-117.
inline Return classify(const LaserScan& scan, float range_m) {
  if (std::isnan(range_m)) return Return::kUnknown;
  if (std::isinf(range_m)) return range_m > 0 ? Return::kFree : Return::kTooClose;
  if (range_m < scan.range_min_m) return Return::kTooClose;
  if (range_m > scan.range_max_m) return Return::kUnknown;
  return Return::kHit;
}

/// What a scanner's +inf means, which REP-117 defines and not every driver means.
struct ScanRules {
  bool inf_is_free = true;
  bool require_return = true;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit(
        "inf_is_free", inf_is_free,
        Field{"",
              "+inf is a free beam, as REP-117 says; false where the driver sends it for failed echoes too, "
              "from black or slanted surfaces: then it says nothing"});
    visit(
        "require_return", require_return,
        Field{"",
              "a scan without a single return is no scan: so a covered or dead laser reads. false for halls "
              "larger than its range"});
  }
};

/// Why a scan cannot be used (empty, wrong increments, NaN only, ...); nullopt for a sound one.
std::optional<std::string> findFault(const LaserScan& scan);
/// The same, and what the rules forbid.
std::optional<std::string> findFault(const LaserScan& scan, const ScanRules& rules);

/// The scan as it is to be read by the rules: +inf becomes NaN where it says nothing.
LaserScan readBy(const ScanRules& rules, LaserScan scan);

/// Where a beam's hit or too-close return lies in the sensor's frame [m], a too-close one at range_min;
/// nullopt when it has neither.
std::optional<Eigen::Vector2d> obstacleAt(const LaserScan& scan, std::size_t beam);

/// obstacleAt() of all beams, in the base's frame [m].
std::vector<Eigen::Vector2d> obstaclePoints(const LaserScan& scan, const Pose2& base_from_laser);

}  // namespace frugal_nav
