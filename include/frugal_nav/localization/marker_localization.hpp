#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include <frugal_nav/common/odometry.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/localization/marker_localization_params.hpp>
#include <frugal_nav/localization/pose_filter.hpp>
#include <frugal_nav/perception/marker_detector.hpp>
#include <frugal_nav/perception/marker_localizer.hpp>
#include <frugal_nav/perception/marker_map.hpp>

namespace frugal_nav {

/// How a picture was taken.
struct MarkerCamera {
  Stamp stamp{};
  Pinhole camera;
  Eigen::Isometry3d base_from_optical = Eigen::Isometry3d::Identity();
};

/// What an image led to, marker by marker.
struct MarkerImageResult {
  Stamp stamp{};
  std::string fault;                   ///< why the image was not used; empty when it was searched
  MarkerFix fix;                       ///< with every marker of the whitelist that is in the image
  std::vector<int> unlisted_ids;       ///< seen, but not on the whitelist
  std::optional<FilterStatus> filter;  ///< what the filter made of a good fix

  /// The fix moved the filter.
  bool isUsed() const { return filter == FilterStatus::kUsed; }
  /// This marker, one of fix.sightings, was part of a fix that moved the filter.
  bool isAccepted(const MarkerSighting& sighting) const;
  /// Why a marker was accepted or not, in words.
  std::string reason(const MarkerSighting& sighting) const;
  /// What the image as a whole came to, in words.
  std::string reason() const;
};

/// Where the robot is at the stamp of an odometry.
struct MapPose {
  PoseEstimate estimate;  ///< map_from_base with its covariance
  Pose2 map_from_odom;    ///< at the same stamp
};

/// What an odometry led to.
struct OdometryResult {
  FilterStatus filter = FilterStatus::kUsed;  ///< what the filter made of it as the twist source
  std::optional<MapPose> pose;
};

/// How localization fares.
struct LocalizationStatus {
  enum class State {
    kNoFix,           ///< no marker of the map was used yet: there is no pose
    kMarkers,         ///< a fix within without_markers_s
    kWithoutMarkers,  ///< dead reckoning
    kLost             ///< and so for so long that the position's sigma is beyond max_sigma_m
  };
  State state = State::kNoFix;
  MotionSource source = MotionSource::kNone;
  double without_markers_s = 0.0;  ///< since the last fix that was used, or since the pose was set
  double sigma_m = 0.0;            ///< of the position, its worst way
  std::string reason;              ///< in words, with what is missing

  /// Pose, markers in view, and twist and gyro too.
  bool isSound() const { return state == State::kMarkers && source == MotionSource::kTwistAndGyro; }
};
const char* toText(LocalizationStatus::State state);

/// Pose in a map of markers from a camera, wheels and gyro (paper 001): the markers' detector, the fit over
/// all markers in view and the Kalman filter, put together.
///
/// `received` is the ROS time at which an input came in. When it goes back, time has jumped, and everything
/// but the counts and what is switched on or off is forgotten.
class MarkerLocalization {
 public:
  /// Throws ConfigError on parameters out of range, a dictionary other than the map's, and an id that the
  /// dictionary does not have.
  MarkerLocalization(const MarkerLocalizationParams& params, const MarkerMap& map);

  /// Wheel odometry: its twist moves the filter when the twist source is the encoders; the pose is given at
  /// its stamp, at each stamp once. None before the first fix, for a stamp that is not after the last, from
  /// the future or older than the history, and for a pose that is not finite.
  OdometryResult addOdometry(const Odometry& odometry, Stamp received);
  /// The pose at the stamp of another input while the odometry is silent; nothing while it is not.
  std::optional<PoseEstimate> poseWithoutOdometry(Stamp stamp);
  /// Commanded velocity, for a base without encoders.
  FilterStatus addCommand(Stamp stamp, const Twist2& twist, Stamp received);
  /// Yaw rate of the IMU [rad/s].
  FilterStatus addGyro(Stamp stamp, double rate_radps, Stamp received);

  /// An 8-bit image, grey or BGR.
  MarkerImageResult addImage(const MarkerCamera& taken, const cv::Mat& image, Stamp received);
  /// The same for markers that were found elsewhere.
  MarkerImageResult addCorners(const MarkerCamera& taken, const MarkerFindings& findings, Stamp received);

  /// Puts the robot somewhere, as of the stamp.
  FilterStatus setPose(Stamp stamp, const PoseFix& fix, Stamp received);
  /// Forgets everything but the counts, and what is switched on or off: time has jumped.
  void reset();

  /// An input that is switched off is refused and counted; kPose is that of the markers, whose images are
  /// then still searched.
  void setEnabled(FilterInput input, bool enabled) { filter_.setEnabled(input, enabled); }
  bool isEnabled(FilterInput input) const { return filter_.isEnabled(input); }
  /// New parameters for a running filter, which goes on; throws ConfigError and changes nothing.
  void setParams(const MarkerLocalizationParams& params);

  /// The newest estimate, and that of an instant; see PoseFilter.
  std::optional<PoseEstimate> estimate() const { return filter_.estimate(); }
  std::optional<PoseEstimate> estimateAt(Stamp stamp) const { return filter_.estimateAt(stamp); }
  /// How it fares at an instant.
  LocalizationStatus status(Stamp now) const;
  const PoseFilterCounts& counts() const { return filter_.counts(); }
  const MarkerMap& map() const { return map_; }

 private:
  std::optional<PoseEstimate> takePose(Stamp stamp);
  Twist2 twistOf(const Odometry& odometry) const;
  std::optional<Pose2> predictedAt(Stamp stamp) const;
  const MarkerLocalizer& localizerFor(const MarkerCamera& taken);
  std::string faultOf(const MarkerCamera& taken, Stamp received) const;
  void noticeJump();

  MarkerLocalizationParams params_;
  MarkerMap map_;
  MarkerDetector detector_;
  PoseFilter filter_;
  std::optional<MarkerLocalizer> localizer_;  ///< for the camera as it was last
  Pinhole camera_;
  Eigen::Isometry3d base_from_optical_ = Eigen::Isometry3d::Identity();
  std::optional<Odometry> last_odometry_;
  std::optional<Stamp> last_pose_;  ///< given out
  std::optional<Stamp> last_fix_;   ///< used
  std::optional<Stamp> last_set_;   ///< when a pose was given by setPose
  std::uint64_t time_jumps_ = 0;    ///< of the filter, noticed
};

}  // namespace frugal_nav
