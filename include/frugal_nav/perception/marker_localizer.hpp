#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/perception/marker_detector.hpp>
#include <frugal_nav/perception/marker_map.hpp>
#include <frugal_nav/perception/marker_pose.hpp>

namespace frugal_nav {
namespace marker_detail {
struct Residuals;
}

/// How far the robot is believed to stand flat on the floor, and the markers where the map says.
struct MarkerLocalizerParams {
  MarkerPoseParams pose;
  double height_sigma_m = 0.02;
  double tilt_sigma_deg = 1.0;
  double max_floor_sigmas = 4.0;
  double map_sigma_m = 0.0;
  double map_sigma_deg = 0.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("pose", pose);
    visit("height_sigma_m", height_sigma_m,
          Field{"m",
                "standard deviation of base_link from z = 0 of the map: floor, mounting, heights in the map",
                0.001, 10.0});
    visit(
        "tilt_sigma_deg", tilt_sigma_deg,
        Field{"deg", "standard deviation of roll and pitch: floor, mounting, angles in the map", 0.05, 90.0});
    visit(
        "max_floor_sigmas", max_floor_sigmas,
        Field{"",
              "a fix farther off the floor, in those deviations, is refused: wrong size or place of a marker",
              1.0, 100.0});
    visit("map_sigma_m", map_sigma_m,
          Field{"m",
                "standard deviation of a marker's place in the map, each way: 0.01 by tape measure, 0 of a "
                "drawing",
                0.0, 1.0});
    visit("map_sigma_deg", map_sigma_deg, Field{"deg", "the same of its angles: 0.5 by eye", 0.0, 10.0});
  }
};

/// One marker of an image and what came of it.
struct MarkerSighting {
  enum class Use {
    kUsed,
    kUnmapped,     ///< it has no place in the map
    kTwice,        ///< its id is in the image more than once
    kRefused,      ///< pose.status says why
    kInconsistent  ///< it contradicts the other markers
  };
  MarkerCorners corners;
  MarkerPose pose;
  Use use = Use::kRefused;
};

/// Where the robot is, by all known markers in view.
struct MarkerFix {
  enum class Status {
    kGood,
    kNoMarker,      ///< none in view that can be used
    kAmbiguous,     ///< two places fit alike and nothing decides between them
    kInconsistent,  ///< the markers contradict each other
    kOffFloor       ///< the robot would float or lie: a wrong size or place
  };

  Status status = Status::kNoMarker;
  Pose2 map_from_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of x [m], y [m], yaw [rad]
  double image_error_px = 0.0;                           ///< mean over the corners of the markers used
  std::optional<Pose2> alternative;                      ///< the next best place, such as a flip's
  std::vector<MarkerSighting> sightings;                 ///< all in the image, by id

  bool isGood() const { return status == Status::kGood; }
};

/// In words, for messages.
const char* toText(MarkerFix::Status status);
const char* toText(MarkerSighting::Use use);

/// The robot's pose in the map of markers (paper 001, which leaves the map out).
///
/// One least-squares fit over the corners of all known markers in view: in pixels, through the lens, with the
/// floor (z = 0, no roll, no pitch) as a soft measurement. It starts from every solution of every marker, so
/// that a flip of one is settled by the others, by the floor, or by the predicted pose.
class MarkerLocalizer {
 public:
  /// base_from_optical: the camera (x right, y down, z ahead) in base_link. Throws ConfigError on parameters
  /// out of range and on a camera with a fault.
  MarkerLocalizer(const MarkerLocalizerParams& params, MarkerMap map, const Pinhole& camera,
                  const Eigen::Isometry3d& base_from_optical);

  /// `predicted` is where the robot is expected (map_from_base); it decides where the image does not.
  MarkerFix locate(const std::vector<MarkerCorners>& markers,
                   const std::optional<Pose2>& predicted = {}) const;

  const MarkerMap& map() const { return map_; }

 private:
  struct Candidate;
  std::vector<MarkerSighting> inspect(const std::vector<MarkerCorners>& markers,
                                      const std::optional<Pose2>& predicted) const;
  std::vector<Candidate> fitAll(const std::vector<MarkerSighting>& sightings) const;
  void addMarker(const MarkerSighting& sighting, const Eigen::Isometry3d& map_from_base,
                 marker_detail::Residuals& residuals) const;
  void addFloor(const Eigen::Isometry3d& map_from_base, marker_detail::Residuals& residuals) const;
  Matrix6d covarianceOf(const std::vector<MarkerSighting>& sightings, const Candidate& best) const;
  double imageError(const MarkerSighting& sighting, const Eigen::Isometry3d& map_from_base) const;
  MarkerFix::Status choose(const std::optional<Pose2>& predicted, int markers_used,
                           std::vector<Candidate>& candidates) const;
  Eigen::Vector3d floorResidual(const Eigen::Isometry3d& map_from_base) const;

  MarkerLocalizerParams params_;
  MarkerMap map_;
  MarkerPoseEstimator estimator_;
  Eigen::Isometry3d base_from_optical_;
};

}  // namespace frugal_nav
