#include <array>
#include <cmath>
#include <map>
#include <vector>

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <frugal_nav/odometry/visual_bundle_adjustment.hpp>

namespace frugal_nav {
namespace {

constexpr double kHuber_px = 1.0;
constexpr double kNearest_m = 0.01;    // a point that a camera has nearer, or behind it, is no sight of it
constexpr double kCauchySigmas = 2.0;  // a wheel distance off by more is taken for slip

/// camera_from_odom as an angle-axis vector and a translation.
using PoseBlock = std::array<double, 6>;

/// A point of the map.
struct PointBlock {
  std::int64_t id;
  std::array<double, 3> position;
};

PoseBlock toBlock(const Eigen::Isometry3d& odom_from_camera) {
  const Eigen::Isometry3d camera_from_odom = odom_from_camera.inverse();
  const Eigen::AngleAxisd turn(camera_from_odom.linear());
  const Eigen::Vector3d v = turn.angle() * turn.axis();
  const Eigen::Vector3d& t = camera_from_odom.translation();
  return {v.x(), v.y(), v.z(), t.x(), t.y(), t.z()};
}

Eigen::Isometry3d fromBlock(const PoseBlock& block) {
  const Eigen::Vector3d v(block[0], block[1], block[2]);
  Eigen::Isometry3d camera_from_odom = Eigen::Isometry3d::Identity();
  if (v.norm() > 0.0)
    camera_from_odom.linear() = Eigen::AngleAxisd(v.norm(), v.normalized()).toRotationMatrix();
  camera_from_odom.translation() = Eigen::Vector3d(block[3], block[4], block[5]);
  return camera_from_odom.inverse();
}

/// Reprojection error of a point [px].
struct SightError {
  Ray2 ray;
  double focal_px;

  template <typename T>
  bool operator()(const T* pose, const T* point, T* residual) const {
    T p[3];
    ceres::AngleAxisRotatePoint(pose, point, p);
    const T z = p[2] + pose[5];
    if (z < T(1e-3)) return false;
    residual[0] = focal_px * ((p[0] + pose[3]) / z - ray.x());
    residual[1] = focal_px * ((p[1] + pose[4]) / z - ray.y());
    return true;
  }
};

/// Where a camera stands: -R^T t.
template <typename T>
void centreOf(const T* pose, T* centre) {
  const T back[3] = {-pose[0], -pose[1], -pose[2]};
  ceres::AngleAxisRotatePoint(back, pose + 3, centre);
  for (int i = 0; i < 3; ++i) centre[i] = -centre[i];
}

/// The way between two cameras less the wheels' [sigmas].
struct DistanceError {
  double distance_m;
  double sigma_m;

  template <typename T>
  bool operator()(const T* pose_a, const T* pose_b, T* residual) const {
    T a[3];
    T b[3];
    centreOf(pose_a, a);
    centreOf(pose_b, b);
    T square(1e-12);  // keeps the root's derivative finite where the cameras coincide
    for (int i = 0; i < 3; ++i) square += (a[i] - b[i]) * (a[i] - b[i]);
    residual[0] = (sqrt(square) - distance_m) / sigma_m;
    return true;
  }
};

/// The base's height above the floor and its tilt [sigmas].
struct FloorError {
  PlanarPrior planar;

  template <typename T>
  bool operator()(const T* pose, T* residual) const {
    const T back[3] = {-pose[0], -pose[1], -pose[2]};
    const Eigen::Vector3d& base = planar.camera_from_base.translation();
    const Eigen::Vector3d up = planar.camera_from_base.linear().col(2);
    const T offset[3] = {T(base.x()) - pose[3], T(base.y()) - pose[4], T(base.z()) - pose[5]};
    T p[3];
    ceres::AngleAxisRotatePoint(back, offset, p);
    const T up_camera[3] = {T(up.x()), T(up.y()), T(up.z())};
    T u[3];
    ceres::AngleAxisRotatePoint(back, up_camera, u);
    residual[0] = p[2] / planar.sigma_m;
    residual[1] = u[0] / planar.sigma_rad;
    residual[2] = u[1] / planar.sigma_rad;
    return true;
  }
};

double rms(const VisualMap& map, double focal_px) {
  double sum = 0.0;
  int count = 0;
  for (const Keyframe& keyframe : map.keyframes()) {
    const Eigen::Isometry3d camera_from_odom = keyframe.odom_from_camera.inverse();
    for (const auto& [id, ray] : keyframe.rays) {
      const auto landmark = map.landmarks().find(id);
      if (landmark == map.landmarks().end()) continue;
      const Eigen::Vector3d p = camera_from_odom * landmark->second.p_odom;
      if (p.z() <= 0.0) continue;
      sum += focal_px * focal_px * (p.head<2>() / p.z() - ray).squaredNorm();
      ++count;
    }
  }
  return count == 0 ? 0.0 : std::sqrt(sum / count);
}

/// The window as Ceres sees it.
class Problem {
 public:
  Problem(VisualMap& map, const BundleSettings& settings)
      : map_(map), settings_(settings), poses_(map.keyframes().size()) {
    points_.reserve(map.landmarks().size());  // Ceres keeps pointers into it
    for (std::size_t i = 0; i < poses_.size(); ++i) poses_[i] = toBlock(map.keyframes()[i].odom_from_camera);
  }

  int build() {
    const std::size_t fixed = poses_.size() > settings_.window ? poses_.size() - settings_.window : 1;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      problem_.AddParameterBlock(poses_[i].data(), 6);
      addSights(i);
      if (settings_.planar && i >= fixed) {
        problem_.AddResidualBlock(
            new ceres::AutoDiffCostFunction<FloorError, 3, 6>(new FloorError{*settings_.planar}), nullptr,
            poses_[i].data());
      }
    }
    const int distances = addDistances(fixed);
    for (std::size_t i = 0; i < fixed; ++i) problem_.SetParameterBlockConstant(poses_[i].data());
    if (distances == 0 && fixed == 1) problem_.SetParameterBlockConstant(poses_[1].data());
    return sights_;
  }

  bool solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = settings_.max_iterations;
    options.function_tolerance = 1e-4;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    auto* ordering = new ceres::ParameterBlockOrdering;
    for (PointBlock& point : points_) ordering->AddElementToGroup(point.position.data(), 0);
    for (PoseBlock& pose : poses_) ordering->AddElementToGroup(pose.data(), 1);
    options.linear_solver_ordering.reset(ordering);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary.IsSolutionUsable();
  }

  void writeBack() {
    for (std::size_t i = 0; i < poses_.size(); ++i)
      map_.keyframes()[i].odom_from_camera = fromBlock(poses_[i]);
    for (const auto& [id, block] : points_) map_.landmarks()[id].p_odom = {block[0], block[1], block[2]};
  }

 private:
  void addSights(std::size_t keyframe) {
    const Eigen::Isometry3d camera_from_odom = map_.keyframes()[keyframe].odom_from_camera.inverse();
    for (const auto& [id, ray] : map_.keyframes()[keyframe].rays) {
      const auto landmark = map_.landmarks().find(id);
      if (landmark == map_.landmarks().end()) continue;
      const Eigen::Vector3d& p = landmark->second.p_odom;
      if ((camera_from_odom * p).z() < kNearest_m) continue;  // one such would end the adjustment of all
      const auto place = index_.emplace(id, points_.size());
      if (place.second) points_.push_back({id, {p.x(), p.y(), p.z()}});
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<SightError, 2, 6, 3>(new SightError{ray, settings_.focal_px}),
          new ceres::HuberLoss(kHuber_px), poses_[keyframe].data(),
          points_[place.first->second].position.data());
      ++sights_;
    }
  }

  int addDistances(std::size_t first) {
    int count = 0;
    for (std::size_t i = first; i < poses_.size(); ++i) {
      const auto& from = map_.keyframes()[i - 1].wheels_from_camera;
      const auto& to = map_.keyframes()[i].wheels_from_camera;
      if (!from || !to) continue;
      const double distance_m = (to->translation() - from->translation()).norm();
      if (distance_m < settings_.min_wheel_distance_m) continue;
      const double sigma_m = std::hypot(settings_.wheel_sigma * distance_m, settings_.wheel_sigma_m);
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<DistanceError, 1, 6, 6>(new DistanceError{distance_m, sigma_m}),
          new ceres::CauchyLoss(kCauchySigmas), poses_[i - 1].data(), poses_[i].data());
      ++count;
    }
    return count;
  }

  VisualMap& map_;
  const BundleSettings& settings_;
  std::vector<PoseBlock> poses_;
  // In one piece of memory: Ceres orders blocks by their address, and sums in that order.
  std::vector<PointBlock> points_;
  std::map<std::int64_t, std::size_t> index_;  // of points_ by feature id
  ceres::Problem problem_;
  int sights_ = 0;
};

}  // namespace

BundleResult adjustBundle(VisualMap& map, const BundleSettings& settings) {
  BundleResult result;
  if (map.keyframes().size() < 2 || map.empty()) return result;
  result.rms_before_px = rms(map, settings.focal_px);
  Problem problem(map, settings);
  result.residuals = problem.build();
  if (result.residuals == 0) return result;
  result.is_usable = problem.solve();
  if (result.is_usable) problem.writeBack();
  result.rms_after_px = rms(map, settings.focal_px);
  return result;
}

}  // namespace frugal_nav
