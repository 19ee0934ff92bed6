#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/odometry/visual_geometry.hpp>
#include <frugal_nav/odometry/visual_params.hpp>

namespace frugal_nav {

/// A view that the map rests on.
struct Keyframe {
  Eigen::Isometry3d odom_from_camera = Eigen::Isometry3d::Identity();
  /// Where the wheels put the camera, in their own odom; nothing without wheels.
  std::optional<Eigen::Isometry3d> wheels_from_camera;
  std::map<std::int64_t, Ray2> rays;  ///< by feature id
};

/// A point of the map.
struct Landmark {
  Eigen::Vector3d p_odom = Eigen::Vector3d::Zero();
  double parallax_rad = 0.0;  ///< largest angle between the rays of its sights
  int sights = 0;             ///< keyframes that see it
  int most_sights = 0;        ///< the most there ever were
  double sigma_m = 0.0;       ///< along the ray, from the parallax
};

/// The last keyframes and the points they see.
class VisualMap {
 public:
  VisualMap(const VisualMapParams& params, double focal_px) : params_(params), focal_px_(focal_px) {}

  bool empty() const { return landmarks_.empty(); }
  const std::deque<Keyframe>& keyframes() const { return keyframes_; }
  std::deque<Keyframe>& keyframes() { return keyframes_; }
  const std::map<std::int64_t, Landmark>& landmarks() const { return landmarks_; }
  std::map<std::int64_t, Landmark>& landmarks() { return landmarks_; }

  /// Adds a view; beyond the window the oldest one goes.
  void addKeyframe(Keyframe keyframe);
  /// Makes points of the features that the keyframes see from angles wide enough. Returns how many.
  int triangulateNew();
  /// Takes out sights that are off, then points that are no longer held by two; renews parallax and sigma.
  void clean();
  /// Points that went out of the window since the last call and were well seen.
  std::vector<Eigen::Vector3d> takeRetired();
  /// Median depth of the points seen in the newest keyframe [m]; nullopt without any.
  std::optional<double> medianDepth() const;
  /// Grows or shrinks the map about a place.
  void rescale(double factor, const Eigen::Vector3d& about_odom);
  /// Forgets everything; well seen points count as retired.
  void clear();

 private:
  std::vector<Sight> sightsOf(std::int64_t id) const;
  void retire(const Landmark& landmark);

  VisualMapParams params_;
  double focal_px_;
  std::deque<Keyframe> keyframes_;
  std::map<std::int64_t, Landmark> landmarks_;
  std::vector<Eigen::Vector3d> retired_;
};

}  // namespace frugal_nav
