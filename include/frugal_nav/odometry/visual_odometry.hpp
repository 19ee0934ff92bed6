#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/odometry/visual_geometry.hpp>
#include <frugal_nav/odometry/visual_params.hpp>
#include <frugal_nav/odometry/visual_status.hpp>

namespace frugal_nav {

/// A map point that the present image shows.
struct VisualPoint {
  std::int64_t id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< in the image as given, distorted
  Eigen::Vector3d p_camera = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_odom = Eigen::Vector3d::Zero();
  double sigma_m = 0.0;  ///< of its depth, without the scale's
};

/// One image for visual odometry.
struct VisualInput {
  Stamp stamp{};
  cv::Mat image;  ///< mono, BGR, RGB or with alpha; 8 or 16 bits
  /// Wheel odometry at the image's stamp; nothing when it is missing.
  std::optional<Eigen::Isometry3d> odom_from_base;
  /// Image region of the nearest obstacle, to be searched more densely [px of the image].
  std::optional<cv::Rect> region;
};

/// What visual odometry knows after an image.
struct VisualOdometryOutput {
  Stamp stamp{};
  VisualStatus status;
  Eigen::Isometry3d odom_from_camera = Eigen::Isometry3d::Identity();  ///< of the optical frame
  Eigen::Isometry3d odom_from_base = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< of odom_from_base: x, y, z, turns about x, y, z of odom
  bool is_metric = false;                  ///< points and motion are in metres: the wheels gave the scale
  bool is_keyframe = false;
  std::vector<VisualPoint> points;       ///< seen in this image, from the local map
  std::vector<cv::Point2f> features;     ///< all features followed in this image
  std::vector<Eigen::Vector3d> retired;  ///< well seen points (odom) that left the local map: for VisualCloud
};

/// Monocular visual odometry with the scale of the wheels.
///
/// Features are followed (optical flow or ORB), two views with a baseline start a map (five-point essential
/// matrix, triangulation), each image gets its pose from the map (PnP), and the last keyframes are adjusted
/// with their points, held to the wheels' distances and to the floor. Where the camera only turns there is no
/// parallax: the direction comes from the images and the position from the wheels. When the images are of no
/// use the state is lost, with the reason; the pose follows the wheels and a new map starts by itself.
class VisualOdometry {
 public:
  /// Throws ConfigError on parameters out of range or a camera that is not calibrated.
  VisualOdometry(const VisualOdometryParams& params, const Pinhole& camera,
                 const Eigen::Isometry3d& base_from_camera);
  ~VisualOdometry();
  VisualOdometry(VisualOdometry&&) noexcept;
  VisualOdometry& operator=(VisualOdometry&&) noexcept;

  /// Takes the next image. A stamp older than the last forgets everything first. An image of another size is
  /// taken as the calibrated one resized; nothing is refused silently, the status tells.
  VisualOdometryOutput process(const VisualInput& input);
  /// Forgets map and pose; the next pose is that of the wheels.
  void reset();
  /// A new calibration, from the next image on; the map is forgotten, the pose is not. Throws ConfigError
  /// when it is none.
  void setCamera(const Pinhole& camera);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace frugal_nav
