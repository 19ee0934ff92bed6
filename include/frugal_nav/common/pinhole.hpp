#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

namespace frugal_nav {

/// A point after a mapping, with the mapping's derivative there.
struct MappedPoint {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};

/// A pinhole camera with plumb-bob distortion (Brown; OpenCV's and camera_info's order of coefficients).
/// The optical frame looks along z, x right, y down (REP-103); the centre of the first pixel is (0, 0).
struct Pinhole {
  int width_px = 0;
  int height_px = 0;
  double fx = 0.0;  ///< focal lengths [px]
  double fy = 0.0;
  double cx = 0.0;  ///< principal point [px]
  double cy = 0.0;
  double k1 = 0.0;
  double k2 = 0.0;
  double p1 = 0.0;
  double p2 = 0.0;
  double k3 = 0.0;

  /// What makes the camera unusable, with its values; empty when sound.
  std::string fault() const;

  /// The same camera when its images are resized to another size, whole image to whole image.
  Pinhole scaled(int new_width_px, int new_height_px) const;

  /// The distorted point of an undistorted one, both at distance one; the derivative is by the latter.
  MappedPoint distort(const Eigen::Vector2d& undistorted) const;

  /// Pixel of a point of the optical frame; nullopt behind the camera.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_optical) const;

  /// Where a pixel looks: (x, y) of the point at z = 1, with its derivative by the pixel. By Newton's method;
  /// nullopt where the distortion has no inverse.
  std::optional<MappedPoint> lookThrough(const Eigen::Vector2d& pixel) const;
};

inline bool operator==(const Pinhole& a, const Pinhole& b) {
  return a.width_px == b.width_px && a.height_px == b.height_px && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy && a.k1 == b.k1 && a.k2 == b.k2 && a.p1 == b.p1 && a.p2 == b.p2 &&
         a.k3 == b.k3;
}
inline bool operator!=(const Pinhole& a, const Pinhole& b) { return !(a == b); }

}  // namespace frugal_nav
