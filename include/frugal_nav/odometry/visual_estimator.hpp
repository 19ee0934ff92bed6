#pragma once

#include <optional>

#include <Eigen/Geometry>

#include <frugal_nav/odometry/visual_bundle_adjustment.hpp>
#include <frugal_nav/odometry/visual_map.hpp>
#include <frugal_nav/odometry/visual_params.hpp>
#include <frugal_nav/odometry/visual_rays.hpp>
#include <frugal_nav/odometry/visual_scale.hpp>
#include <frugal_nav/odometry/visual_status.hpp>
#include <frugal_nav/odometry/visual_stray_watch.hpp>

namespace frugal_nav {

/// What one image brought.
struct VisualUpdate {
  VisualState state = VisualState::kInitializing;
  VisualReason reason = VisualReason::kNone;
  int inliers = 0;
  Matrix6d covariance = Matrix6d::Zero();  ///< of the pose against the map, in the camera's frame
  bool is_keyframe = false;
};

/// Visual odometry behind the images: rays in, poses and a map out.
class VisualEstimator {
 public:
  /// `focal_px` turns rays to pixels. The parameters must be valid.
  VisualEstimator(const VisualOdometryParams& params, double focal_px,
                  const Eigen::Isometry3d& base_from_camera);

  /// Takes the next image's rays and where the wheels put the camera then, in their own frame.
  VisualUpdate update(const RayMap& rays, const std::optional<Eigen::Isometry3d>& wheels_from_camera);
  /// The image was of no use: gives the map up and follows the wheels.
  void lose(const std::optional<Eigen::Isometry3d>& wheels_from_camera);
  /// Forgets everything, the pose too: the next one is that of the wheels.
  void reset();
  /// Another image size: the map stays no longer valid, the pose is kept.
  void setFocal(double focal_px);

  const Eigen::Isometry3d& odomFromCamera() const { return odom_from_camera_; }
  /// The camera's motion since the last image as the wheels tell it; nullopt when they do not.
  std::optional<Eigen::Isometry3d> wheelMotion(
      const std::optional<Eigen::Isometry3d>& wheels_from_camera) const;
  const VisualMap& map() const { return map_; }
  VisualMap& map() { return map_; }
  /// The map is in metres.
  bool isMetric() const { return is_metric_; }
  std::optional<VisualScale::Estimate> scale() const { return scale_.estimate(); }

 private:
  /// The view that a new map may start from.
  struct Anchor {
    Eigen::Isometry3d odom_from_camera;
    std::optional<Eigen::Isometry3d> wheels_from_camera;
    RayMap rays;
    std::size_t most_shared = 0;  ///< features that an image had in common with it
  };
  void predict();
  void setAnchor(const RayMap& rays);
  bool isThin(const SharedRays& shared) const;
  VisualUpdate withoutMap(const RayMap& rays);
  VisualUpdate turnOnly(const RayMap& rays, const SharedRays& shared, const RotationFit& turn);
  VisualReason tryStart(const RayMap& rays, const SharedRays& shared, int& inliers);
  bool agreesWithWheels(const Eigen::Isometry3d& anchor_from_now, double course_error_rad) const;
  VisualUpdate track(const RayMap& rays);
  VisualReason findPoseInMap(const RayMap& rays, VisualUpdate& update, PoseFit& fit);
  bool isTooFarFromWheels(const Eigen::Isometry3d& odom_from_camera) const;
  bool straysFromWheels(const RayMap& rays);
  bool needsKeyframe(int inliers) const;
  void addKeyframe(const RayMap& rays);
  void sampleScale();
  void dropMap();
  Eigen::Isometry3d flattened(const Eigen::Isometry3d& odom_from_camera) const;
  BundleSettings bundleSettings() const;
  std::optional<PlanarPrior> planarPrior() const;

  VisualOdometryParams params_;
  double focal_px_;
  Eigen::Isometry3d base_from_camera_;
  VisualMap map_;
  VisualScale scale_;
  bool has_pose_ = false;
  bool is_metric_ = false;
  Eigen::Isometry3d odom_from_camera_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d last_motion_ = Eigen::Isometry3d::Identity();  // for prediction without wheels
  std::optional<Eigen::Isometry3d> wheels_from_camera_;            // now
  std::optional<Eigen::Isometry3d> last_wheels_;
  std::optional<Anchor> anchor_;
  VisualStrayWatch stray_;
  int keyframe_inliers_ = 0;
};

}  // namespace frugal_nav
