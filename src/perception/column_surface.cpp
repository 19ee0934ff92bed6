#include <algorithm>
#include <cmath>
#include <limits>

#include <frugal_nav/perception/column_surface.hpp>

namespace frugal_nav {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

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

/// The third nearest of a column: one or two pixels are noise, or another surface's edge.
Pixel nearestOf(std::vector<Pixel>& pixels) {
  const std::size_t rank = std::min<std::size_t>(2, pixels.size() - 1);
  std::nth_element(pixels.begin(), pixels.begin() + static_cast<std::ptrdiff_t>(rank), pixels.end(),
                   [](const Pixel& a, const Pixel& b) { return a.inverse > b.inverse; });
  return pixels[rank];
}

int topOf(int column, const Pixel& pixel, const cv::Mat& inverse) {
  constexpr float kSameSurface = 0.25F;
  int top = pixel.row;
  while (top > 0 && std::abs(inverse.at<float>(top - 1, column) / pixel.inverse - 1.0F) < kSameSurface) --top;
  return top;
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
      const Pixel nearest = nearestOf(pixels);
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
    if (surface.state == ColumnSurface::State::kHit)
      surface.p_base = rays.point(surface.row, column, surface.depth_m).head<2>();
    surfaces.push_back(surface);
  }
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
