#pragma once

#include <deque>
#include <optional>

#include <Eigen/Geometry>

#include <frugal_nav/odometry/visual_params.hpp>
#include <frugal_nav/odometry/visual_rays.hpp>

namespace frugal_nav {

/// Notices that many small errors, each of which could be believed, or a map that has shrunk have led a
/// metric visual pose astray from the wheels.
class VisualStrayWatch {
 public:
  /// `focal_px` turns rays to pixels.
  VisualStrayWatch(const VisualCheckParams& checks, double focal_px);

  /// Takes an image's pose, the wheels' (in a frame of their own) and their step since the last image. Gives
  /// the pose that the wheels tell since the last one believed when this one has gone astray.
  std::optional<Eigen::Isometry3d> check(const Eigen::Isometry3d& odom_from_camera,
                                         const Eigen::Isometry3d& wheels_from_camera,
                                         const Eigen::Isometry3d& step, const RayMap& rays);
  /// An image that cannot be compared: the next one starts a new way.
  void pause() { checkpoint_.reset(); }
  /// The map is gone: forgets everything.
  void reset();

 private:
  /// A pose of a moment ago, from which images and wheels must have gone alike.
  struct Checkpoint {
    Eigen::Isometry3d odom_from_camera;
    Eigen::Isometry3d wheels_from_camera;
    double way_m = 0.0;  ///< since then, as the wheels tell it
    double turn_rad = 0.0;
    double denied_m = 0.0;  ///< its last piece that the pose does not follow, though the images show it
  };
  /// One of the last images.
  struct Past {
    Eigen::Isometry3d odom_from_camera;
    RayMap rays;
    double step_m = 0.0;  ///< the way to it, as the wheels tell it
  };

  bool deniesMotion(const Eigen::Isometry3d& odom_from_camera, const RayMap& rays, double step_m);
  bool showsTranslation(const RayMap& before, const RayMap& now) const;

  VisualCheckParams checks_;
  double focal_px_;
  std::optional<Checkpoint> checkpoint_;
  std::deque<Past> recent_;  // images of the last kDeniedWindow_m
};

}  // namespace frugal_nav
