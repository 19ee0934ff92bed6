#include "lens.hpp"

#include <cmath>

namespace frugal_nav::sim {
namespace {

constexpr double kConverged = 1e-12;
constexpr int kMaxIterations = 50;

struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};

/// Brown's plumb-bob model with its derivative; r^2 = x^2 + y^2 of the undistorted point.
Distorted distort(const CameraParams& c, const Eigen::Vector2d& p) {
  const double x = p.x();
  const double y = p.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  const double slope = 2.0 * (c.k1 + r2 * (2.0 * c.k2 + r2 * 3.0 * c.k3));  // d radial / d(r^2 / 2)
  Distorted out;
  out.point = {x * radial + 2.0 * c.p1 * x * y + c.p2 * (r2 + 2.0 * x * x),
               y * radial + c.p1 * (r2 + 2.0 * y * y) + 2.0 * c.p2 * x * y};
  const double mixed = x * y * slope + 2.0 * c.p1 * x + 2.0 * c.p2 * y;
  out.jacobian << radial + x * x * slope + 2.0 * c.p1 * y + 6.0 * c.p2 * x, mixed, mixed,
      radial + y * y * slope + 6.0 * c.p1 * y + 2.0 * c.p2 * x;
  return out;
}

/// The undistorted point by Newton's method; throws where the model has no inverse.
Eigen::Vector2d undistort(const CameraParams& params, const Eigen::Vector2d& distorted) {
  Eigen::Vector2d p = distorted;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Distorted now = distort(params, p);
    if (now.jacobian.determinant() <= 0.0) break;
    const Eigen::Vector2d step = now.jacobian.inverse() * (distorted - now.point);
    p += step;
    if (step.norm() < kConverged) return p;
  }
  throw ConfigError(
      "camera: the distortion k1, k2, p1, p2, k3 folds the image over near its edge; use smaller ones");
}

}  // namespace

Lens::Lens(const CameraParams& params)
    : width_(params.width_px),
      height_(params.height_px),
      focal_px_(0.5 * params.width_px / std::tan(0.5 * params.horizontal_fov_rad)) {
  const cv::Matx33d k = matrix();
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      const Eigen::Vector2d p =
          undistort(params, {(column - k(0, 2)) / focal_px_, (row - k(1, 2)) / focal_px_});
      x_.push_back(static_cast<float>(p.x()));
      y_.push_back(static_cast<float>(p.y()));
    }
  }
}

cv::Matx33d Lens::matrix() const {
  return {focal_px_, 0.0, 0.5 * (width_ - 1), 0.0, focal_px_, 0.5 * (height_ - 1), 0.0, 0.0, 1.0};
}

}  // namespace frugal_nav::sim
