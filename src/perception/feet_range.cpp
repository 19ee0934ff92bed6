#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/perception/feet_range.hpp>

namespace frugal_nav {
namespace {

/// Where the nearest thing of a body's depth stands: the median of the nearest hits that agree, three at
/// least.
std::optional<double> nearestBody(std::vector<double> hits_m) {
  constexpr std::size_t kAgreeing = 3;
  constexpr double kBodyDepth_m = 0.3;
  std::sort(hits_m.begin(), hits_m.end());
  for (std::size_t first = 0; first + kAgreeing <= hits_m.size(); ++first) {
    std::size_t last = first;
    while (last + 1 < hits_m.size() && hits_m[last + 1] <= hits_m[first] + kBodyDepth_m) ++last;
    if (last - first + 1 >= kAgreeing) return hits_m[(first + last) / 2];
  }
  return std::nullopt;
}

}  // namespace

bool standsFree(double bearing_rad, double range_m, const LaserScan& surfaces, const FeetParams& params) {
  constexpr double kInner = 1.5;  // half widths from the middle, within which the air beside it is looked for
  constexpr double kOuter = 3.0;
  constexpr double kBehind_m = 0.4;
  const double half_rad = std::atan2(params.half_width_m, range_m);
  for (const double side : {-1.0, 1.0}) {
    int beams = 0;
    int free = 0;
    for (std::size_t i = 0; i < surfaces.ranges_m.size(); ++i) {
      const double off_rad = side * angleBetween(bearing_rad, surfaces.angleOf(i));
      if (off_rad < kInner * half_rad || off_rad > kOuter * half_rad) continue;
      const Return kind = classify(surfaces, surfaces.ranges_m[i]);
      ++beams;
      free += kind == Return::kFree ||
              (kind == Return::kHit && static_cast<double>(surfaces.ranges_m[i]) > range_m + kBehind_m);
    }
    if (beams == 0 || 2 * free <= beams) return false;
  }
  return true;
}

std::optional<double> bodyRange(double bearing_rad, double range_m, const LaserScan& surfaces,
                                const FeetParams& params) {
  const double half_rad = std::atan2(params.half_width_m, range_m);
  std::vector<double> hits_m;
  for (std::size_t i = 0; i < surfaces.ranges_m.size(); ++i) {
    if (std::abs(angleBetween(bearing_rad, surfaces.angleOf(i))) > half_rad) continue;
    if (classify(surfaces, surfaces.ranges_m[i]) == Return::kHit)
      hits_m.push_back(static_cast<double>(surfaces.ranges_m[i]));
  }
  const std::optional<double> nearest_m = nearestBody(std::move(hits_m));
  if (!nearest_m || *nearest_m > params.max_range_m) return std::nullopt;
  const double ratio = (*nearest_m + params.body_depth_m) / range_m;
  if (ratio > params.max_ratio || ratio < 1.0 / params.max_ratio) return std::nullopt;
  return *nearest_m + params.body_depth_m;
}

}  // namespace frugal_nav
