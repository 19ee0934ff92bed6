#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <frugal_nav/perception/gap_finder.hpp>

namespace frugal_nav {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Direction of a column's edge on the horizon, seen from the camera, left positive [rad].
double cameraBearing(double column, const ViewRays& rays) {
  const int row = std::clamp(rays.firstRowBelowHorizon(static_cast<int>(column)), 0, rays.grid().height - 1);
  const Eigen::Vector3d ray = rays.rayThrough(rays.toImage({column, row}));
  return std::atan2(ray.y(), ray.x());
}

/// Depth ahead of the camera of the bound beside a gap: the nearest of a few columns, which may be blurred.
std::optional<double> boundDepth(int first, int step, const std::vector<ColumnSurface>& surfaces) {
  constexpr int kColumns = 4;
  std::optional<double> nearest;
  for (int i = 0; i < kColumns; ++i) {
    const int column = first + i * step;
    if (column < 0 || column >= static_cast<int>(surfaces.size())) break;
    const ColumnSurface& surface = surfaces[static_cast<std::size_t>(column)];
    if (surface.state != ColumnSurface::State::kHit) continue;
    const auto depth = static_cast<double>(surface.depth_m);
    nearest = nearest ? std::min(*nearest, depth) : depth;
  }
  return nearest;
}

/// The nearest surface within a run; nothing when all is free or unknown.
std::optional<double> depthWithin(const ColumnRun& run, const std::vector<ColumnSurface>& surfaces) {
  std::optional<double> nearest;
  for (int column = run.first; column <= run.last; ++column) {
    const ColumnSurface& surface = surfaces[static_cast<std::size_t>(column)];
    if (surface.state != ColumnSurface::State::kHit) continue;
    const auto depth = static_cast<double>(surface.depth_m);
    nearest = nearest ? std::min(*nearest, depth) : depth;
  }
  return nearest;
}

/// Bearing in base_link of what lies at a depth in a direction from the camera.
double baseBearing(double camera_rad, double depth_m, const ViewRays& rays) {
  const Eigen::Vector2d camera = rays.baseFromOptical().translation().head<2>();
  const Eigen::Vector2d p = camera + depth_m * Eigen::Vector2d(1.0, std::tan(camera_rad));
  return std::atan2(p.y(), p.x());
}

}  // namespace

std::vector<char> openColumns(const ColumnProfile& profile, const std::vector<ColumnSurface>& surfaces,
                              const GapFinderParams& params) {
  const float largest =
      profile.nearest.empty() ? 0.0F : *std::max_element(profile.nearest.begin(), profile.nearest.end());
  const float least = std::max(1e-6F, static_cast<float>(params.least_inverse) * largest);
  const float clip = static_cast<float>(params.clip_ratio) / std::max(largest, least);
  std::vector<char> near = thresholdAtMean(relativeDepths(profile, least, clip), clip);
  const int count = static_cast<int>(near.size());
  flipShortRuns(static_cast<int>(std::lround(params.noise_width * count)), near);
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const ColumnSurface& surface = surfaces[k];
    const auto depth = static_cast<double>(surface.depth_m);
    const bool is_hit = surface.state == ColumnSurface::State::kHit;
    if (is_hit && depth < params.clear_m) near[k] = 1;
    if (params.open_m > 0.0 && surface.state != ColumnSurface::State::kUnknown &&
        (!is_hit || depth > params.open_m))
      near[k] = 0;
    if (profile.states[k] == ColumnProfile::State::kUnknown) near[k] = 1;
  }
  return near;
}

double gapWidth(double depth_m, double left_rad, double right_rad) {
  return depth_m * (std::tan(left_rad) - std::tan(right_rad));
}

Eigen::Vector2d literalGapNode(const Pose2& odom_from_base, int block, double scale_m) {
  return odom_from_base * Eigen::Vector2d(scale_m, -scale_m * block);
}

GapSighting findGap(const std::vector<char>& near, const std::vector<ColumnSurface>& surfaces,
                    const ViewRays& rays, const Pose2& odom_from_base, const GapFinderParams& params) {
  GapSighting gap;
  gap.p_odom = odom_from_base.position();
  const std::optional<ColumnRun> run = longestOpenRun(near);
  const int count = static_cast<int>(near.size());
  if (!run || run->length() < std::max(1.0, params.min_width * count)) {
    gap.reason = run ? "the widest open part is too narrow" : "everything in view is near";
    return gap;
  }
  gap.found = true;
  const double left_edge = run->first - 0.5;
  const double right_edge = run->last + 0.5;
  const double middle = 0.5 * (left_edge + right_edge);
  gap.left_column_px = rays.toImage({left_edge, 0.0}).x();
  gap.right_column_px = rays.toImage({right_edge, 0.0}).x();
  gap.block = blockOf(middle, count);
  const double left = cameraBearing(left_edge, rays);
  const double right = cameraBearing(right_edge, rays);
  const double centre = cameraBearing(middle, rays);

  const std::optional<double> left_bound = boundDepth(run->first - 1, -1, surfaces);
  const std::optional<double> right_bound = boundDepth(run->last + 1, 1, surfaces);
  std::optional<double> depth = left_bound;
  if (right_bound) depth = depth ? std::min(*depth, *right_bound) : *right_bound;
  if (!depth) depth = depthWithin(*run, surfaces);  // no bound in view: as wide as it is at what lies behind
  gap.depth_m = depth.value_or(kNaN);
  if (depth) gap.width_m = gapWidth(*depth, left, right);

  const double at = depth.value_or(params.node_default_m);
  gap.left_bearing_rad = baseBearing(left, at, rays);
  gap.right_bearing_rad = baseBearing(right, at, rays);
  gap.bearing_rad = baseBearing(centre, at, rays);
  const double camera_x = rays.baseFromOptical().translation().x();
  const Eigen::Vector2d node(camera_x + at, (camera_x + at) * std::tan(gap.bearing_rad));
  gap.p_odom = params.node == "literal" ? literalGapNode(odom_from_base, gap.block, params.node_scale_m)
                                        : odom_from_base * node;
  return gap;
}

}  // namespace frugal_nav
