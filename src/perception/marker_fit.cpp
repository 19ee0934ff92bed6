#include "marker_fit.hpp"

#include <cmath>
#include <limits>

#include <frugal_nav/perception/marker_map.hpp>

namespace frugal_nav::marker_detail {
namespace {

Eigen::Isometry3d moved(const Eigen::Isometry3d& pose, const Vector6d& step) {
  Eigen::Isometry3d result = pose;
  result.translation() += step.head<3>();
  const Eigen::Vector3d turn = step.tail<3>();
  const double angle = turn.norm();
  if (angle > 0.0) {
    const Eigen::Quaterniond turned =
        Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) * Eigen::Quaterniond(pose.linear());
    result.linear() = turned.normalized().toRotationMatrix();
  }
  return result;
}

}  // namespace

Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

PoseFit fitPose(const Eigen::Isometry3d& start,
                const std::function<Residuals(const Eigen::Isometry3d&)>& evaluate) {
  constexpr int kMaxSteps = 30;
  constexpr double kSmallGain = 1e-9;
  PoseFit fit{start, evaluate(start)};
  if (!fit.residuals.valid) return fit;
  double damping = 1e-4;
  for (int i = 0; i < kMaxSteps; ++i) {
    Matrix6d damped = fit.residuals.information;
    damped.diagonal() *= 1.0 + damping;
    const Vector6d step = -damped.ldlt().solve(fit.residuals.gradient);
    if (!step.allFinite()) break;
    const Eigen::Isometry3d candidate = moved(fit.pose, step);
    const Residuals residuals = evaluate(candidate);
    if (!residuals.valid || !(residuals.cost <= fit.residuals.cost)) {
      damping *= 10.0;
      if (damping > 1e8) break;
      continue;
    }
    const double gain = fit.residuals.cost - residuals.cost;
    fit = {candidate, residuals};
    damping = std::max(1e-9, damping / 10.0);
    if (gain <= kSmallGain * (1.0 + residuals.cost)) break;
  }
  return fit;
}

void addCorner(const Pinhole& camera, const Eigen::Vector3d& p_optical, const PointJacobian& jacobian,
               const Eigen::Vector2d& pixel, double sigma_px, Residuals& residuals) {
  constexpr double kMinDepth_m = 1e-3;
  if (!(p_optical.z() > kMinDepth_m)) {
    residuals.valid = false;
    return;
  }
  const double z = p_optical.z();
  const MappedPoint bent = camera.distort(p_optical.head<2>() / z);
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  Eigen::Matrix<double, 2, 3> flat_by_point;
  flat_by_point << 1.0 / z, 0.0, -p_optical.x() / (z * z), 0.0, 1.0 / z, -p_optical.y() / (z * z);
  const Eigen::Vector2d shown = focal.cwiseProduct(bent.point) + Eigen::Vector2d(camera.cx, camera.cy);
  const Eigen::Matrix<double, 2, 6> pixel_by_motion =
      focal.asDiagonal() * bent.jacobian * flat_by_point * jacobian;
  residuals.add<2>((shown - pixel) / sigma_px, pixel_by_motion / sigma_px);
}

double imageError(const Pinhole& camera, const MarkerCorners& corners, double size_m,
                  const Eigen::Isometry3d& camera_from_marker) {
  const auto points = markerCorners(size_m);
  double sum_px = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto pixel = camera.project(camera_from_marker * points[i]);
    if (!pixel) return std::numeric_limits<double>::infinity();
    sum_px += (*pixel - corners.pixels[i]).norm();
  }
  return sum_px / 4.0;
}

}  // namespace frugal_nav::marker_detail
