#include <cmath>

#include <frugal_nav/perception/view_rays.hpp>

namespace frugal_nav {
namespace {

bool sameCamera(const Pinhole& a, const Pinhole& b) {
  return a.width_px == b.width_px && a.height_px == b.height_px && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy && a.k1 == b.k1 && a.k2 == b.k2 && a.p1 == b.p1 && a.p2 == b.p2 &&
         a.k3 == b.k3;
}

}  // namespace

ViewRays::ViewRays(const Pinhole& camera, const Eigen::Isometry3d& base_from_optical, const cv::Size& grid)
    : camera_(camera),
      base_from_optical_(base_from_optical),
      grid_(grid),
      origin_(base_from_optical.translation().cast<float>()) {
  rays_.reserve(static_cast<std::size_t>(grid.area()));
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column)
      rays_.push_back(rayThrough(toImage({column, row})).cast<float>());
  }
}

bool ViewRays::fits(const Pinhole& camera, const Eigen::Isometry3d& base_from_optical,
                    const cv::Size& grid) const {
  return sameCamera(camera, camera_) && base_from_optical.matrix() == base_from_optical_.matrix() &&
         grid == grid_;
}

Eigen::Vector3d ViewRays::rayThrough(const Eigen::Vector2d& pixel) const {
  const auto seen = camera_.lookThrough(pixel);
  if (!seen) return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  return base_from_optical_.linear() * Eigen::Vector3d(seen->point.x(), seen->point.y(), 1.0);
}

int ViewRays::firstRowBelowHorizon(int column, double margin_rad) const {
  const auto slope = static_cast<float>(-std::tan(margin_rad));
  for (int row = grid_.height - 1; row >= 0; --row) {
    const Eigen::Vector3f& r = ray(row, column);
    if (!(r.z() < slope * r.head<2>().norm())) return row + 1;  // NaN ends it too
  }
  return 0;
}

Eigen::Vector2d ViewRays::toGrid(const Eigen::Vector2d& pixel) const {
  return {(pixel.x() + 0.5) * grid_.width / camera_.width_px - 0.5,
          (pixel.y() + 0.5) * grid_.height / camera_.height_px - 0.5};
}

Eigen::Vector2d ViewRays::toImage(const Eigen::Vector2d& cell) const {
  return {(cell.x() + 0.5) * camera_.width_px / grid_.width - 0.5,
          (cell.y() + 0.5) * camera_.height_px / grid_.height - 0.5};
}

}  // namespace frugal_nav
