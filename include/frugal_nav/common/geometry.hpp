#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Geometry>

namespace frugal_nav {

/// Angle wrapped to (-pi, pi] [rad].
inline double wrapAngle(double angle_rad) {
  const double wrapped = std::remainder(angle_rad, 2.0 * M_PI);
  return wrapped <= -M_PI ? wrapped + 2.0 * M_PI : wrapped;
}

/// Smallest signed rotation that leads from one angle to another, in (-pi, pi] [rad].
inline double angleBetween(double from_rad, double to_rad) { return wrapAngle(to_rad - from_rad); }

/// Rigid motion in the plane. Named a_from_b it takes points given in frame b to frame a.
struct Pose2 {
  double x_m = 0.0;
  double y_m = 0.0;
  double yaw_rad = 0.0;

  Eigen::Vector2d position() const { return {x_m, y_m}; }
  bool isFinite() const { return std::isfinite(x_m) && std::isfinite(y_m) && std::isfinite(yaw_rad); }

  /// The inverse motion: b_from_a of a_from_b.
  Pose2 inverse() const {
    const double c = std::cos(yaw_rad);
    const double s = std::sin(yaw_rad);
    return {-c * x_m - s * y_m, s * x_m - c * y_m, wrapAngle(-yaw_rad)};
  }

  /// A point of frame b in frame a.
  Eigen::Vector2d operator*(const Eigen::Vector2d& p_b) const {
    const double c = std::cos(yaw_rad);
    const double s = std::sin(yaw_rad);
    return {x_m + c * p_b.x() - s * p_b.y(), y_m + s * p_b.x() + c * p_b.y()};
  }

  /// a_from_c = a_from_b * b_from_c.
  Pose2 operator*(const Pose2& b_from_c) const {
    const Eigen::Vector2d p = *this * b_from_c.position();
    return {p.x(), p.y(), wrapAngle(yaw_rad + b_from_c.yaw_rad)};
  }
};

/// A pose on the floor as one in space.
inline Eigen::Isometry3d toIsometry(const Pose2& pose) {
  Eigen::Isometry3d lifted = Eigen::Isometry3d::Identity();
  lifted.linear() = Eigen::AngleAxisd(pose.yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  lifted.translation() << pose.x_m, pose.y_m, 0.0;
  return lifted;
}

/// Where a pose in space stands on the floor, and where its x axis points there.
inline Pose2 toPose2(const Eigen::Isometry3d& pose) {
  return {pose.translation().x(), pose.translation().y(), std::atan2(pose(1, 0), pose(0, 0))};
}

/// Planar velocity of a differential-drive base, in its own frame.
struct Twist2 {
  double v_mps = 0.0;
  double w_radps = 0.0;

  bool isFinite() const { return std::isfinite(v_mps) && std::isfinite(w_radps); }
  bool isZero() const { return v_mps == 0.0 && w_radps == 0.0; }
};

inline bool operator==(const Twist2& a, const Twist2& b) {
  return a.v_mps == b.v_mps && a.w_radps == b.w_radps;
}
inline bool operator!=(const Twist2& a, const Twist2& b) { return !(a == b); }

/// Distance between two positions [m].
inline double distance(const Pose2& a, const Pose2& b) { return std::hypot(b.x_m - a.x_m, b.y_m - a.y_m); }

/// Bearing of a point as seen from a pose, left positive, in (-pi, pi] [rad].
inline double bearingTo(const Pose2& from, const Eigen::Vector2d& p) {
  return wrapAngle(std::atan2(p.y() - from.y_m, p.x() - from.x_m) - from.yaw_rad);
}

/// Motion of a body that holds `twist` for `duration_s`, along the exact arc.
inline Pose2 arcMotion(const Twist2& twist, double duration_s) {
  const double angle = twist.w_radps * duration_s;
  const double length = twist.v_mps * duration_s;
  // sin(a)/a and (1-cos(a))/a, by their series near zero, where the quotients lose all digits.
  const double along = std::abs(angle) < 1e-6 ? 1.0 - angle * angle / 6.0 : std::sin(angle) / angle;
  const double aside = std::abs(angle) < 1e-6 ? angle / 2.0 : (1.0 - std::cos(angle)) / angle;
  return {length * along, length * aside, wrapAngle(angle)};
}

/// Pose between two poses: 0 gives `a`, 1 gives `b`; the yaw turns the short way.
inline Pose2 interpolate(const Pose2& a, const Pose2& b, double fraction) {
  return {a.x_m + fraction * (b.x_m - a.x_m), a.y_m + fraction * (b.y_m - a.y_m),
          wrapAngle(a.yaw_rad + fraction * angleBetween(a.yaw_rad, b.yaw_rad))};
}

/// A path: poses in one frame, in driving order.
using Path2 = std::vector<Pose2>;
/// A polygon: corners in counter-clockwise order [m].
using Polygon2 = std::vector<Eigen::Vector2d>;

}  // namespace frugal_nav
