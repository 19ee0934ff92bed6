#include <algorithm>
#include <cmath>
#include <limits>

#include <frugal_nav/perception/column_surface.hpp>

namespace frugal_nav {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kHiddenSigma = 0.3F;  // of a depth that is known to be below one value only

/// Rows of a column that are no floor and low enough for the robot, with their inverse depths.
struct Pixel {
  int row;
  float inverse;
};

std::vector<Pixel> obstaclePixels(int column, const cv::Mat& inverse, const FloorContact& contact,
                                  const ViewRays& rays, const DepthScanParams& params) {
  const int lowest = contact.state == FloorContact::State::kOpen ? contact.row - 1 : contact.row;
  std::vector<Pixel> pixels;
  for (int row = std::min(lowest, inverse.rows - 1); row >= 0; --row) {
    const float q = inverse.at<float>(row, column);
    if (!(q * static_cast<float>(params.max_range_m) > 0.9F)) continue;
    if (rays.heightAt(row, column, 1.0F / q) > static_cast<float>(params.max_height_m)) continue;
    pixels.push_back({row, q});
  }
  return pixels;
}

/// The pixel whose inverse depth has that rank among a column's, the nearest first.
Pixel ranked(std::vector<Pixel> pixels, std::size_t rank) {
  rank = std::min(rank, pixels.size() - 1);
  std::nth_element(pixels.begin(), pixels.begin() + static_cast<std::ptrdiff_t>(rank), pixels.end(),
                   [](const Pixel& a, const Pixel& b) { return a.inverse > b.inverse; });
  return pixels[rank];
}

/// The nearest of a column, lowest pixel first: one or two pixels are noise, or another surface's edge. Where
/// a thing stands on the floor it is what lies right above its foot, unless something hangs over well nearer.
Pixel nearestOf(const std::vector<Pixel>& pixels, bool has_foot) {
  const Pixel nearest = ranked(pixels, 2);
  constexpr std::size_t kFoot = 7;
  if (!has_foot || pixels.size() < 3) return nearest;
  const std::vector<Pixel> low(pixels.begin(),
                               pixels.begin() + static_cast<std::ptrdiff_t>(std::min(kFoot, pixels.size())));
  const Pixel foot = ranked(low, low.size() / 2);
  constexpr float kOverhang = 1.35F;
  return nearest.inverse > kOverhang * foot.inverse ? nearest : foot;
}

int topOf(int column, const Pixel& pixel, const cv::Mat& inverse) {
  constexpr float kSameSurface = 0.25F;
  int top = pixel.row;
  while (top > 0 && std::abs(inverse.at<float>(top - 1, column) / pixel.inverse - 1.0F) < kSameSurface) --top;
  return top;
}

/// Depth at which the floor line puts a column: infinite where the floor runs on.
float footDepth(const FloorContact& contact) {
  return contact.state == FloorContact::State::kContact ? static_cast<float>(contact.depth_m) : kInfinity;
}

/// The network blurs the edges of near things over what lies behind them: columns beside one, nearer than
/// their own foot, hang in the air between the two. Their foot tells, or nothing does.
void dropFlying(const std::vector<FloorContact>& contacts, const ViewRays& rays, int reach,
                std::vector<ColumnSurface>& surfaces) {
  constexpr float kBehind = 1.15F;
  constexpr float kBeforeFoot = 0.9F;
  const std::vector<ColumnSurface> seen = surfaces;
  const int count = static_cast<int>(seen.size());
  for (int column = 0; column < count; ++column) {
    ColumnSurface& surface = surfaces[static_cast<std::size_t>(column)];
    const FloorContact& contact = contacts[static_cast<std::size_t>(column)];
    const bool has_foot = contact.state != FloorContact::State::kHidden;
    if (surface.state != ColumnSurface::State::kHit) continue;
    if (!has_foot || surface.depth_m > kBeforeFoot * footDepth(contact)) continue;
    bool is_beside_nearer = false;
    for (int k = std::max(0, column - reach); k <= std::min(count - 1, column + reach); ++k) {
      const ColumnSurface& other = seen[static_cast<std::size_t>(k)];
      const FloorContact& foot = contacts[static_cast<std::size_t>(k)];
      const bool stands =
          foot.state == FloorContact::State::kHidden || footDepth(foot) < kBehind * other.depth_m;
      is_beside_nearer = is_beside_nearer || (other.state == ColumnSurface::State::kHit && stands &&
                                              kBehind * other.depth_m < footDepth(contact));
    }
    if (!is_beside_nearer) continue;
    if (contact.state != FloorContact::State::kContact) {
      surface.state = ColumnSurface::State::kUnknown;
      continue;
    }
    surface.row = contact.row;
    surface.depth_m = footDepth(contact);
    surface.relative_sigma = static_cast<float>(contact.sigma_m / contact.depth_m);
    surface.p_base = rays.point(surface.row, column, surface.depth_m).head<2>();
  }
}

/// At an upright edge some columns lie between what is near and what is far, and are neither. A wall seen at
/// a flat angle recedes by less from column to column.
void dropBetween(const DepthScanParams& params, std::vector<ColumnSurface>& surfaces) {
  constexpr int kReach = 2;
  const auto step = static_cast<float>(params.between_m);
  const auto far = static_cast<float>(params.max_range_m);
  std::vector<float> ranges;
  for (const ColumnSurface& surface : surfaces) {
    switch (surface.state) {
      case ColumnSurface::State::kHit:
        ranges.push_back(std::min(surface.p_base.norm(), far));
        break;
      case ColumnSurface::State::kFree:
        ranges.push_back(far);
        break;
      case ColumnSurface::State::kUnknown:  // neither near nor far: no hit beside it is doubted
        ranges.push_back(kNaN);
        break;
    }
  }
  const int count = static_cast<int>(surfaces.size());
  for (int column = kReach; column + kReach < count; ++column) {
    const auto k = static_cast<std::size_t>(column);
    if (surfaces[k].state != ColumnSurface::State::kHit) continue;
    const float before = ranges[k] - ranges[k - kReach];
    const float after = ranges[k + kReach] - ranges[k];
    if (before * after > 0.0F && std::min(std::abs(before), std::abs(after)) > step)
      surfaces[k].state = ColumnSurface::State::kUnknown;
  }
}

struct Sector {
  double left_rad;
  double right_rad;
};

/// Bearings of the view's edges in base_link, from far away.
Sector viewOf(const ViewRays& rays) {
  double left = -M_PI;
  double right = M_PI;
  for (int row = 0; row < rays.grid().height; ++row) {
    const Eigen::Vector3f& l = rays.ray(row, 0);
    const Eigen::Vector3f& r = rays.ray(row, rays.grid().width - 1);
    if (l.allFinite()) left = std::max(left, static_cast<double>(std::atan2(l.y(), l.x())));
    if (r.allFinite()) right = std::min(right, static_cast<double>(std::atan2(r.y(), r.x())));
  }
  return {left, right};
}

LaserScan emptyScan(double left_rad, double right_rad, Stamp stamp, const DepthScanParams& params) {
  LaserScan scan;
  scan.stamp = stamp;
  scan.angle_increment_rad = params.beam_rad;
  // Seen from base_link, what is near lies wider than the lens shows it from farther ahead: a margin for
  // that.
  const double half = std::max(std::abs(left_rad), std::abs(right_rad)) + 0.1;
  const int beams = 2 * static_cast<int>(half / params.beam_rad) + 1;
  scan.angle_min_rad = -params.beam_rad * (beams / 2);
  scan.range_min_m = params.min_range_m;
  scan.range_max_m = params.max_range_m;
  scan.ranges_m.assign(static_cast<std::size_t>(beams), kNaN);
  return scan;
}

}  // namespace

std::vector<ColumnSurface> findSurfaces(const cv::Mat& inverse_depth_pm, const cv::Mat& relative_sigma,
                                        const std::vector<FloorContact>& contacts, const ViewRays& rays,
                                        const DepthScanParams& params) {
  std::vector<ColumnSurface> surfaces;
  for (int column = 0; column < rays.grid().width; ++column) {
    const FloorContact& contact = contacts[static_cast<std::size_t>(column)];
    const bool has_line = contact.state == FloorContact::State::kContact;
    ColumnSurface surface;
    surface.row = surface.top_row = contact.row;
    std::vector<Pixel> pixels;
    if (!inverse_depth_pm.empty()) {
      pixels = obstaclePixels(column, inverse_depth_pm, contact, rays, params);
      surface.state = contact.state == FloorContact::State::kHidden && pixels.empty()
                          ? ColumnSurface::State::kUnknown
                          : ColumnSurface::State::kFree;
    }
    if (pixels.size() >= 2) {
      const Pixel nearest = nearestOf(pixels, has_line);
      surface.state = ColumnSurface::State::kHit;
      surface.row = nearest.row;
      surface.depth_m = 1.0F / nearest.inverse;
      surface.relative_sigma = relative_sigma.at<float>(nearest.row, column);
      surface.top_row = topOf(column, nearest, inverse_depth_pm);
    }
    // What stands on the floor is at least as near as its line, whatever the network says.
    if (has_line && (surface.state != ColumnSurface::State::kHit ||
                     surface.depth_m > static_cast<float>(contact.depth_m + contact.sigma_m))) {
      surface.state = ColumnSurface::State::kHit;
      surface.row = contact.row;
      surface.top_row = std::min(surface.top_row, contact.row);
      surface.depth_m = static_cast<float>(contact.depth_m);
      surface.relative_sigma = static_cast<float>(contact.sigma_m / contact.depth_m);
    }
    // Nor is what hides the floor at the image's lower edge farther than that floor.
    const float lowest_pm = rays.inverseFloorDepth(rays.grid().height - 1, column);
    if (contact.state == FloorContact::State::kHidden && lowest_pm > 0.0F &&
        (surface.state != ColumnSurface::State::kHit || surface.depth_m * lowest_pm > 1.0F)) {
      surface.state = ColumnSurface::State::kHit;
      surface.row = surface.top_row = rays.grid().height - 1;
      surface.depth_m = 1.0F / lowest_pm;
      surface.relative_sigma = kHiddenSigma;
    }
    if (surface.state == ColumnSurface::State::kHit)
      surface.p_base = rays.point(surface.row, column, surface.depth_m).head<2>();
    surfaces.push_back(surface);
  }
  dropFlying(contacts, rays, cvRound(params.blur_width * rays.grid().width), surfaces);
  dropBetween(params, surfaces);
  return surfaces;
}

LaserScan scanOf(const std::vector<ColumnSurface>& surfaces, const ViewRays& rays, Stamp stamp,
                 const DepthScanParams& params) {
  const Sector view = viewOf(rays);
  LaserScan scan = emptyScan(view.left_rad, view.right_rad, stamp, params);
  const int middle_row = rays.grid().height / 2;
  for (int column = 0; column < rays.grid().width; ++column) {
    const ColumnSurface& surface = surfaces[static_cast<std::size_t>(column)];
    if (surface.state == ColumnSurface::State::kUnknown) continue;
    const bool is_hit = surface.state == ColumnSurface::State::kHit;
    const Eigen::Vector2f p =
        is_hit ? surface.p_base
               : Eigen::Vector2f(
                     rays.point(middle_row, column, static_cast<float>(params.max_range_m)).head<2>());
    const double bearing = static_cast<double>(std::atan2(p.y(), p.x()));
    const auto beam = std::lround((bearing - scan.angle_min_rad) / scan.angle_increment_rad);
    if (beam < 0 || beam >= static_cast<long>(scan.ranges_m.size())) continue;
    const float range = is_hit && p.norm() <= static_cast<float>(params.max_range_m)
                            ? std::max(p.norm(), static_cast<float>(params.min_range_m))
                            : kInfinity;
    float& kept = scan.ranges_m[static_cast<std::size_t>(beam)];
    if (!(kept <= range)) kept = range;
  }
  return scan;
}

LaserScan unknownScan(const ViewRays* rays, Stamp stamp, const DepthScanParams& params) {
  if (rays == nullptr) return emptyScan(0.0, 0.0, stamp, params);
  const Sector view = viewOf(*rays);
  return emptyScan(view.left_rad, view.right_rad, stamp, params);
}

}  // namespace frugal_nav
