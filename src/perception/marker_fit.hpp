#pragma once

// Least squares over one rigid motion, shared by the pose of a marker and the pose of the robot.

#include <functional>

#include <Eigen/Geometry>

#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/perception/marker_detector.hpp>

namespace frugal_nav::marker_detail {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using PointJacobian = Eigen::Matrix<double, 3, 6>;

/// Residuals, in standard deviations, and their derivative by (dt, dr) of (t + dt, exp(dr) R).
struct Residuals {
  bool valid = true;
  Matrix6d information = Matrix6d::Zero();  ///< J^T J
  Vector6d gradient = Vector6d::Zero();     ///< J^T r
  double cost = 0.0;                        ///< r^T r

  template <int kRows>
  void add(const Eigen::Matrix<double, kRows, 1>& residual, const Eigen::Matrix<double, kRows, 6>& jacobian) {
    information += jacobian.transpose() * jacobian;
    gradient += jacobian.transpose() * residual;
    cost += residual.squaredNorm();
  }
};

/// A motion at the least cost near where it started.
struct PoseFit {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  Residuals residuals;
};

/// Levenberg-Marquardt. The result is invalid when the start is.
PoseFit fitPose(const Eigen::Isometry3d& start,
                const std::function<Residuals(const Eigen::Isometry3d&)>& evaluate);

/// Adds a corner's residual: p_optical is where it should be, with its derivative by the motion.
void addCorner(const Pinhole& camera, const Eigen::Vector3d& p_optical, const PointJacobian& jacobian,
               const Eigen::Vector2d& pixel, double sigma_px, Residuals& residuals);

/// Mean distance of a marker's corners from where a pose puts them [px]; infinite where the lens shows
/// nothing.
double imageError(const Pinhole& camera, const MarkerCorners& corners, double size_m,
                  const Eigen::Isometry3d& camera_from_marker);

/// The matrix that makes the cross product with v.
Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v);

}  // namespace frugal_nav::marker_detail
