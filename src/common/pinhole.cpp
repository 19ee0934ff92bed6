#include <cmath>
#include <sstream>

#include <Eigen/LU>

#include <frugal_nav/common/pinhole.hpp>

namespace frugal_nav {

std::string Pinhole::fault() const {
  std::ostringstream out;
  if (width_px <= 0 || height_px <= 0) {
    out << "the camera's image size is " << width_px << "x" << height_px;
  } else if (!(std::isfinite(fx) && std::isfinite(fy) && fx > 0.0 && fy > 0.0)) {
    out << "the camera's focal lengths are fx = " << fx << ", fy = " << fy
        << "; calibrate it (camera_calibration) and give its driver the file";
  } else if (!(cx >= 0.0 && cx < width_px && cy >= 0.0 && cy < height_px)) {
    out << "the camera's principal point (" << cx << ", " << cy << ") is outside of its " << width_px << "x"
        << height_px << " image";
  } else if (!std::isfinite(k1 + k2 + p1 + p2 + k3)) {
    out << "the camera's distortion is not finite";
  }
  return out.str();
}

Pinhole Pinhole::scaled(int new_width_px, int new_height_px) const {
  const double sx = static_cast<double>(new_width_px) / width_px;
  const double sy = static_cast<double>(new_height_px) / height_px;
  Pinhole camera = *this;
  camera.width_px = new_width_px;
  camera.height_px = new_height_px;
  camera.fx *= sx;
  camera.fy *= sy;
  // Resizing maps the images' edges, which lie half a pixel before the first centre.
  camera.cx = (cx + 0.5) * sx - 0.5;
  camera.cy = (cy + 0.5) * sy - 0.5;
  return camera;
}

MappedPoint Pinhole::distort(const Eigen::Vector2d& undistorted) const {
  const double x = undistorted.x();
  const double y = undistorted.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));  // d radial / d(r^2 / 2)
  MappedPoint out;
  out.point = {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
               y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
  const double mixed = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
  out.jacobian << radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x, mixed,  //
      mixed, radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
  return out;
}

std::optional<Eigen::Vector2d> Pinhole::project(const Eigen::Vector3d& p_optical) const {
  if (!(p_optical.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d p = distort(p_optical.head<2>() / p_optical.z()).point;
  return Eigen::Vector2d(fx * p.x() + cx, fy * p.y() + cy);
}

std::optional<MappedPoint> Pinhole::lookThrough(const Eigen::Vector2d& pixel) const {
  constexpr int kSteps = 20;
  constexpr double kTolerance = 1e-12;
  const Eigen::Vector2d wanted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  Eigen::Vector2d p = wanted;
  for (int i = 0; i < kSteps; ++i) {
    const MappedPoint now = distort(p);
    if (!(now.jacobian.determinant() > 0.0)) return std::nullopt;  // past the fold
    const Eigen::Matrix2d inverse = now.jacobian.inverse();
    const Eigen::Vector2d step = inverse * (wanted - now.point);
    p += step;
    if (step.squaredNorm() < kTolerance * kTolerance) {
      const Eigen::Vector2d per_pixel(1.0 / fx, 1.0 / fy);
      return MappedPoint{p, inverse * per_pixel.asDiagonal()};
    }
  }
  return std::nullopt;
}

}  // namespace frugal_nav
