#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include <frugal_nav/odometry/visual_geometry.hpp>

namespace frugal_nav {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr double kHuber_px = 1.0;  // beyond it a reprojection error counts linearly

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

Eigen::Matrix3d rotationOf(const Eigen::Vector3d& turn_rad) {
  const double angle = turn_rad.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn_rad / angle).toRotationMatrix();
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<cv::Point2d> toCv(const std::vector<Ray2>& rays) {
  std::vector<cv::Point2d> points;
  points.reserve(rays.size());
  for (const Ray2& ray : rays) points.emplace_back(ray.x(), ray.y());
  return points;
}

Eigen::Vector3d bearing(const Ray2& ray) { return Eigen::Vector3d(ray.x(), ray.y(), 1.0).normalized(); }

/// Normal equations of one Gauss-Newton step on camera_from_world, moved by (translation, turn) on its left.
struct NormalEquations {
  Matrix6d h = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();

  template <int kRows>
  void add(const Eigen::Matrix<double, kRows, 6>& jacobian, const Eigen::Matrix<double, kRows, 1>& residual,
           double weight) {
    h.noalias() += weight * jacobian.transpose() * jacobian;
    g.noalias() += weight * jacobian.transpose() * residual;
  }
};

/// Reprojection error in pixels; infinite behind the camera.
double addPoint(NormalEquations& equations, const Eigen::Isometry3d& camera_from_world,
                const Eigen::Vector3d& p_world, const Ray2& ray, double focal_px, double cut_px) {
  const Eigen::Vector3d p = camera_from_world * p_world;
  if (p.z() < 1e-3) return std::numeric_limits<double>::infinity();
  const Eigen::Vector2d residual = focal_px * (p.head<2>() / p.z() - ray);
  const double error = residual.norm();
  if (error > cut_px) return error;
  Eigen::Matrix<double, 2, 3> by_point;
  by_point << 1.0 / p.z(), 0.0, -p.x() / (p.z() * p.z()), 0.0, 1.0 / p.z(), -p.y() / (p.z() * p.z());
  Eigen::Matrix<double, 2, 6> jacobian;
  jacobian.leftCols<3>() = focal_px * by_point;
  jacobian.rightCols<3>() = -focal_px * by_point * cross(p);
  equations.add<2>(jacobian, residual, error <= kHuber_px ? 1.0 : kHuber_px / error);
  return error;
}

/// The base's height and the x and y of its upright axis in the world, as residuals of their sigmas.
void addFloor(NormalEquations& equations, const Eigen::Isometry3d& camera_from_world,
              const PlanarPrior& planar) {
  const Eigen::Isometry3d world_from_camera = camera_from_world.inverse();
  const Eigen::Matrix3d& r = world_from_camera.linear();
  const Eigen::Vector3d base = planar.camera_from_base.translation();
  const Eigen::Vector3d up = planar.camera_from_base.linear().col(2);
  Eigen::Matrix<double, 3, 6> jacobian = Eigen::Matrix<double, 3, 6>::Zero();
  jacobian.block<1, 3>(0, 0) = -r.row(2) / planar.sigma_m;
  jacobian.block<1, 3>(0, 3) = r.row(2) * cross(base) / planar.sigma_m;
  jacobian.block<2, 3>(1, 3) = r.topRows<2>() * cross(up) / planar.sigma_rad;
  const Eigen::Vector3d up_world = r * up;
  const Eigen::Vector3d residual((world_from_camera * base).z() / planar.sigma_m,
                                 up_world.x() / planar.sigma_rad, up_world.y() / planar.sigma_rad);
  equations.add<3>(jacobian, residual, 1.0);
}

}  // namespace

std::optional<PoseFit> refinePose(const std::vector<Eigen::Vector3d>& p_world, const std::vector<Ray2>& rays,
                                  const Eigen::Isometry3d& world_from_camera_guess, double focal_px,
                                  double max_error_px, const std::optional<PlanarPrior>& planar) {
  if (p_world.size() < 6) return std::nullopt;
  Eigen::Isometry3d camera_from_world = world_from_camera_guess.inverse();
  std::vector<double> errors(p_world.size());
  NormalEquations equations;
  constexpr int kSteps = 12;
  for (int step = 0; step < kSteps; ++step) {
    // A wide cut first: the guess may be some pixels off; then only what fits.
    const double cut_px = step < 4 ? 20.0 * max_error_px : max_error_px;
    equations = NormalEquations();
    for (std::size_t i = 0; i < p_world.size(); ++i)
      errors[i] = addPoint(equations, camera_from_world, p_world[i], rays[i], focal_px, cut_px);
    if (planar) addFloor(equations, camera_from_world, *planar);
    const Eigen::LDLT<Matrix6d> solver(equations.h);
    if (solver.info() != Eigen::Success || !(solver.rcond() > 1e-14)) return std::nullopt;
    const Vector6d delta = solver.solve(-equations.g);
    if (!delta.allFinite()) return std::nullopt;
    const Eigen::Matrix3d turn = rotationOf(delta.tail<3>());
    camera_from_world.linear() = turn * camera_from_world.linear();
    camera_from_world.translation() = turn * camera_from_world.translation() + delta.head<3>();
    if (step >= 5 && delta.norm() < 1e-7) break;
  }
  PoseFit fit;
  fit.world_from_camera = camera_from_world.inverse();
  fit.covariance = equations.h.inverse();
  for (const double error : errors) {
    fit.is_inlier.push_back(error <= max_error_px ? 1 : 0);
    fit.inliers += fit.is_inlier.back();
  }
  fit.median_error_px = median(errors);
  return fit;
}

std::optional<Eigen::Isometry3d> findPose(const std::vector<Eigen::Vector3d>& p_world,
                                          const std::vector<Ray2>& rays, double focal_px,
                                          double max_error_px) {
  if (p_world.size() < 6) return std::nullopt;
  std::vector<cv::Point3d> points;
  for (const Eigen::Vector3d& p : p_world) points.emplace_back(p.x(), p.y(), p.z());
  cv::Mat rotation;
  cv::Mat translation;
  std::vector<int> inliers;
  constexpr int kDraws = 100;
  const bool found = cv::solvePnPRansac(
      points, toCv(rays), cv::Matx33d::eye(), cv::noArray(), rotation, translation, false, kDraws,
      static_cast<float>(max_error_px / focal_px), 0.99, inliers, cv::SOLVEPNP_AP3P);
  if (!found || inliers.size() < 6) return std::nullopt;
  cv::Mat matrix;
  cv::Rodrigues(rotation, matrix);
  Eigen::Isometry3d camera_from_world = Eigen::Isometry3d::Identity();
  Eigen::Matrix3d r;
  Eigen::Vector3d t;
  cv::cv2eigen(matrix, r);
  cv::cv2eigen(translation, t);
  if (!r.allFinite() || !t.allFinite()) return std::nullopt;
  camera_from_world.linear() = r;
  camera_from_world.translation() = t;
  return camera_from_world.inverse();
}

std::optional<RotationFit> fitRotation(const std::vector<Ray2>& rays_a, const std::vector<Ray2>& rays_b,
                                       double focal_px, double max_error_px) {
  if (rays_a.size() < 3) return std::nullopt;
  std::vector<double> weights(rays_a.size(), 1.0);
  std::vector<double> errors(rays_a.size());
  RotationFit fit;
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < rays_a.size(); ++i)
      sum += weights[i] * bearing(rays_b[i]) * bearing(rays_a[i]).transpose();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d sign(1.0, 1.0, (svd.matrixU() * svd.matrixV().transpose()).determinant());
    fit.b_from_a = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
    for (std::size_t i = 0; i < rays_a.size(); ++i) {
      errors[i] = focal_px * (fit.b_from_a * bearing(rays_a[i]) - bearing(rays_b[i])).norm();
      const double ratio = errors[i] / max_error_px;
      weights[i] = 1.0 / (1.0 + ratio * ratio);  // Cauchy
    }
  }
  fit.median_residual_px = median(errors);
  fit.inliers = static_cast<int>(
      std::count_if(errors.begin(), errors.end(), [&](double e) { return e < max_error_px; }));
  return fit;
}

std::optional<TwoViewFit> findTwoViewMotion(const std::vector<Ray2>& rays_a, const std::vector<Ray2>& rays_b,
                                            double focal_px, double max_error_px) {
  if (rays_a.size() < 8) return std::nullopt;
  const std::vector<cv::Point2d> a = toCv(rays_a);
  const std::vector<cv::Point2d> b = toCv(rays_b);
  cv::Mat mask;
  const cv::Mat essential =
      cv::findEssentialMat(a, b, cv::Matx33d::eye(), cv::RANSAC, 0.999, max_error_px / focal_px, mask);
  if (essential.rows != 3 || essential.cols != 3) return std::nullopt;
  cv::Mat rotation;
  cv::Mat translation;
  const int in_front = cv::recoverPose(essential, a, b, cv::Matx33d::eye(), rotation, translation, mask);
  if (2 * in_front < static_cast<int>(rays_a.size())) return std::nullopt;
  Eigen::Matrix3d r;
  Eigen::Vector3d t;
  cv::cv2eigen(rotation, r);
  cv::cv2eigen(translation, t);
  Eigen::Isometry3d b_from_a = Eigen::Isometry3d::Identity();
  b_from_a.linear() = r;
  b_from_a.translation() = t;
  TwoViewFit fit;
  fit.a_from_b = b_from_a.inverse();
  for (int i = 0; i < mask.rows; ++i) fit.is_inlier.push_back(mask.at<unsigned char>(i) != 0 ? 1 : 0);
  fit.inliers = in_front;
  return fit;
}

std::optional<Triangulation> triangulate(const std::vector<Sight>& sights, double focal_px) {
  if (sights.size() < 2) return std::nullopt;
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> directions;
  double least_cos = 1.0;
  for (const Sight& sight : sights) {
    const Eigen::Vector3d d = sight.world_from_camera.linear() * bearing(sight.ray);
    for (const Eigen::Vector3d& other : directions) least_cos = std::min(least_cos, d.dot(other));
    directions.push_back(d);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    a += across;
    b += across * sight.world_from_camera.translation();
  }
  Triangulation result;
  result.parallax_rad = std::acos(std::clamp(least_cos, -1.0, 1.0));
  const Eigen::LDLT<Eigen::Matrix3d> solver(a);
  if (result.parallax_rad < 1e-6 || solver.info() != Eigen::Success) return std::nullopt;
  result.p_world = solver.solve(b);
  Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  for (const Sight& sight : sights) {
    const Eigen::Matrix3d camera_from_world = sight.world_from_camera.linear().transpose();
    const Eigen::Vector3d p = camera_from_world * (result.p_world - sight.world_from_camera.translation());
    if (!(p.z() > 1e-3)) return std::nullopt;
    Eigen::Matrix<double, 2, 3> by_point;
    by_point << 1.0 / p.z(), 0.0, -p.x() / (p.z() * p.z()), 0.0, 1.0 / p.z(), -p.y() / (p.z() * p.z());
    const Eigen::Matrix<double, 2, 3> jacobian = by_point * camera_from_world;
    h += jacobian.transpose() * jacobian;
    g += jacobian.transpose() * (p.head<2>() / p.z() - sight.ray);
  }
  result.p_world -= h.ldlt().solve(g);
  for (const Sight& sight : sights) {
    const Eigen::Vector3d p = sight.world_from_camera.inverse() * result.p_world;
    if (!(p.z() > 1e-3)) return std::nullopt;
    result.error_px = std::max(result.error_px, focal_px * (p.head<2>() / p.z() - sight.ray).norm());
  }
  return result;
}

}  // namespace frugal_nav
