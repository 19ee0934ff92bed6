#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/perception/marker_detector.hpp>

namespace frugal_nav {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// What is believed of a marker's pose.
struct MarkerPoseParams {
  double corner_sigma_px = 0.3;
  double clipped_sigma_px = 1.5;
  double max_image_error_px = 2.0;
  double min_side_px = 12.0;
  double min_range_m = 0.1;
  double max_range_m = 8.0;
  double max_view_angle_deg = 78.0;
  double flip_ratio = 2.5;
  double same_pose_deg = 4.0;
  double max_prediction_error_deg = 25.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("corner_sigma_px", corner_sigma_px,
          Field{"px",
                "standard deviation of a corner, each way: twice its scatter in sharp images, since images "
                "in a row err alike",
                0.02, 10.0});
    visit("clipped_sigma_px", clipped_sigma_px,
          Field{"px", "the same of a marker whose white is overexposed, and so spreads over the black", 0.02,
                20.0});
    visit("max_image_error_px", max_image_error_px,
          Field{"px", "a pose whose corners lie farther off on average is refused", 0.1, 50.0});
    visit("min_side_px", min_side_px,
          Field{"px", "a marker with a shorter side in the image tells too little", 4.0, 500.0});
    visit("min_range_m", min_range_m, Field{"m", "nearer markers are not believed", 0.0, 10.0});
    visit("max_range_m", max_range_m, Field{"m", "farther markers are not believed", 0.2, 100.0});
    visit("max_view_angle_deg", max_view_angle_deg,
          Field{"deg", "a marker seen more from the side than that is refused; 0 is from straight ahead",
                10.0, 89.0});
    visit("flip_ratio", flip_ratio,
          Field{"",
                "image error of the second solution over the first's (at least corner_sigma_px) that decides "
                "between the two",
                1.0, 100.0});
    visit("same_pose_deg", same_pose_deg,
          Field{"deg", "two solutions turned by less are one: either will do", 0.0, 30.0});
    visit("max_prediction_error_deg", max_prediction_error_deg,
          Field{"deg", "undecided: the solution within that of the predicted pose is taken", 1.0, 90.0});
  }
  /// Of the corners of one marker.
  double sigmaOf_px(const MarkerCorners& corners) const {
    return corners.is_clipped ? std::max(corner_sigma_px, clipped_sigma_px) : corner_sigma_px;
  }
  std::string check() const {
    return min_range_m < max_range_m ? "" : "min_range_m must be less than max_range_m";
  }
};

/// One of the two poses from which a square looks nearly the same.
struct MarkerSolution {
  Eigen::Isometry3d camera_from_marker = Eigen::Isometry3d::Identity();  ///< optical frame, marker's frame
  double image_error_px = 0.0;  ///< mean distance of the corners from where the pose puts them
};

/// A marker's pose from its corners.
struct MarkerPose {
  enum class Status {
    kGood,
    kNoSolution,  ///< the corners are no square seen through this lens
    kNoEdges,     ///< the corners are too rough
    kTooSmall,    ///< in the image
    kTooNear,     ///< range
    kTooFar,      ///< range
    kTooOblique,  ///< seen from the side
    kLargeError,  ///< image error
    kAmbiguous    ///< the two solutions differ and nothing decides between them
  };

  int id = -1;
  Status status = Status::kNoSolution;
  /// The likelier one first. Two when both lie before the camera, with the smaller image error first, unless
  /// the predicted pose has decided.
  std::vector<MarkerSolution> solutions;
  double error_ratio = 0.0;  ///< image error of the worse solution over the better's, which counts at least
                             ///< corner_sigma_px; 0 when there is only one
  double object_error_m = 0.0;  ///< mean distance of the corners, on the marker's plane, from where they are
  double range_m = 0.0;         ///< from the camera to the centre
  /// Of the first solution's translation [m] and rotation [rad], both about the optical frame's axes:
  /// camera_from_marker = (t + dt, exp(dr) R).
  Matrix6d covariance = Matrix6d::Zero();

  bool isGood() const { return status == Status::kGood; }
};

/// In words, for messages.
const char* toText(MarkerPose::Status status);

/// Pose of one marker by IPPE_SQUARE (Collins and Bartoli, "Infinitesimal plane-based pose estimation", IJCV
/// 2014), both solutions refined to least reprojection error in pixels, with the lens' distortion.
class MarkerPoseEstimator {
 public:
  /// Throws ConfigError on parameters out of range and on a camera with a fault.
  MarkerPoseEstimator(const MarkerPoseParams& params, const Pinhole& camera);

  /// `predicted` is where the marker is expected (camera_from_marker); it decides where the image does not.
  MarkerPose estimate(const MarkerCorners& corners, double size_m,
                      const std::optional<Eigen::Isometry3d>& predicted = {}) const;

  const MarkerPoseParams& params() const { return params_; }
  const Pinhole& camera() const { return camera_; }

 private:
  void chooseSolution(double sigma_px, const std::optional<Eigen::Isometry3d>& predicted,
                      MarkerPose& pose) const;
  void judge(const MarkerCorners& corners, MarkerPose& pose) const;

  MarkerPoseParams params_;
  Pinhole camera_;
};

}  // namespace frugal_nav
