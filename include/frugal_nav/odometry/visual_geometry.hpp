#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

namespace frugal_nav {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Where a camera looks at something: (x, y) of the point at z = 1 in its optical frame.
using Ray2 = Eigen::Vector2d;

/// By how much a motion turns [rad].
inline double turnOf(const Eigen::Isometry3d& motion) { return Eigen::AngleAxisd(motion.linear()).angle(); }

/// The floor's word on a camera: how the base is mounted below it, and how surely it stands upright at z = 0.
struct PlanarPrior {
  Eigen::Isometry3d camera_from_base = Eigen::Isometry3d::Identity();
  double sigma_m = 0.005;
  double sigma_rad = 0.004;
};

/// A camera's pose by known points.
struct PoseFit {
  Eigen::Isometry3d world_from_camera = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< of (translation, rotation) in the camera's frame
  std::vector<char> is_inlier;
  int inliers = 0;
  double median_error_px = 0.0;
};

/// Iteratively reweighted Gauss-Newton (Huber) on the reprojection errors, from a first guess. `focal_px`
/// turns rays to pixels; points off by more than `max_error_px` are outliers. nullopt with fewer than six
/// points or a singular system.
std::optional<PoseFit> refinePose(const std::vector<Eigen::Vector3d>& p_world, const std::vector<Ray2>& rays,
                                  const Eigen::Isometry3d& world_from_camera_guess, double focal_px,
                                  double max_error_px, const std::optional<PlanarPrior>& planar);

/// A pose without a guess: P3P in RANSAC (OpenCV, its own fixed seed). nullopt when no pose fits.
std::optional<Eigen::Isometry3d> findPose(const std::vector<Eigen::Vector3d>& p_world,
                                          const std::vector<Ray2>& rays, double focal_px,
                                          double max_error_px);

/// The turn that explains how rays moved, were there no translation.
struct RotationFit {
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();
  double median_residual_px = 0.0;  ///< what the turn does not explain
  int inliers = 0;                  ///< residual below `max_error_px`
};

/// Kabsch's rotation between bearings, reweighted against outliers. nullopt with fewer than three rays.
std::optional<RotationFit> fitRotation(const std::vector<Ray2>& rays_a, const std::vector<Ray2>& rays_b,
                                       double focal_px, double max_error_px);

/// Motion between two views up to scale.
struct TwoViewFit {
  Eigen::Isometry3d a_from_b = Eigen::Isometry3d::Identity();  ///< translation of length one
  std::vector<char> is_inlier;
  int inliers = 0;
};

/// Five-point essential matrix in RANSAC, decomposed with all points in front (OpenCV, its own fixed seed).
/// nullopt when fewer than half of the rays fit.
std::optional<TwoViewFit> findTwoViewMotion(const std::vector<Ray2>& rays_a, const std::vector<Ray2>& rays_b,
                                            double focal_px, double max_error_px);

/// One sight of a point.
struct Sight {
  Eigen::Isometry3d world_from_camera;
  Ray2 ray;
};

/// A triangulated point.
struct Triangulation {
  Eigen::Vector3d p_world;
  double parallax_rad = 0.0;  ///< largest angle between two of the rays
  double error_px = 0.0;      ///< largest reprojection error
};

/// Point nearest to all rays in the least-squares sense, refined by one Gauss-Newton step on the images.
/// nullopt when the rays are parallel or the point is behind a camera.
std::optional<Triangulation> triangulate(const std::vector<Sight>& sights, double focal_px);

}  // namespace frugal_nav
