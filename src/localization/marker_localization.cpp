#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/Eigenvalues>

#include <frugal_nav/localization/marker_localization.hpp>

namespace frugal_nav {
namespace {

using Use = MarkerSighting::Use;
using State = LocalizationStatus::State;

/// The detector's parameters with the dictionary of the map, which they may repeat but not contradict.
MarkerDetectorParams withDictionary(MarkerDetectorParams params, const MarkerMap& map) {
  if (!params.dictionary.empty() && params.dictionary != map.dictionary) {
    throw ConfigError("detector/dictionary is \"" + params.dictionary + "\", but the marker map's is \"" +
                      map.dictionary + "\": leave it empty, or say the same in both");
  }
  params.dictionary = map.dictionary;
  return params;
}

/// Standard deviation of a position the way in which it is largest [m].
double worstSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance.topLeftCorner<2, 2>(),
                                                            Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, axes.eigenvalues().maxCoeff()));
}

/// Mean velocity from one odometry to the next. The message's own is a mean over a longer time: it comes late
/// when the robot speeds up.
Twist2 meanTwist(const Odometry& from, const Odometry& to) {
  const double duration_s = toSeconds(to.stamp - from.stamp);
  const Pose2 step = from.odom_from_base.inverse() * to.odom_from_base;
  const double half = 0.5 * step.yaw_rad;
  const double chord_over_arc = std::abs(half) < 1e-6 ? 1.0 : std::sin(half) / half;
  const double length = std::copysign(std::hypot(step.x_m, step.y_m), step.x_m) / chord_over_arc;
  return {length / duration_s, step.yaw_rad / duration_s};
}

std::string inWords(const LocalizationStatus& status) {
  if (status.state == State::kNoFix) return "no fix yet: no marker of the map has been used";
  std::string text = "markers in view";
  if (status.state != State::kMarkers) {
    char since[80];
    std::snprintf(since, sizeof(since), "no marker used for %.1f s, sigma %.2f m", status.without_markers_s,
                  status.sigma_m);
    text = std::string(status.state == State::kLost ? "lost: " : "") + since;
  }
  const bool is_degraded = status.source != MotionSource::kTwistAndGyro;
  return is_degraded ? text + "; " + toText(status.source) : text;
}

}  // namespace

const char* toText(LocalizationStatus::State state) {
  switch (state) {
    case State::kNoFix:
      return "no fix";
    case State::kMarkers:
      return "markers";
    case State::kWithoutMarkers:
      return "without markers";
    case State::kLost:
      return "lost";
  }
  return "";
}

bool MarkerImageResult::isAccepted(const MarkerSighting& sighting) const {
  return isUsed() && sighting.use == Use::kUsed;
}

std::string MarkerImageResult::reason(const MarkerSighting& sighting) const {
  if (sighting.use == Use::kRefused) return toText(sighting.pose.status);
  return sighting.use == Use::kUsed ? reason() : toText(sighting.use);
}

std::string MarkerImageResult::reason() const {
  if (!fault.empty()) return fault;
  if (!fix.isGood()) return toText(fix.status);
  return filter ? toText(*filter) : "";
}

MarkerLocalization::MarkerLocalization(const MarkerLocalizationParams& params, const MarkerMap& map)
    : params_(params),
      map_(map),
      detector_(withDictionary(params.detector, map), map.whitelist),
      filter_(params.filter) {
  validate(params_, "marker localization");
}

OdometryResult MarkerLocalization::addOdometry(const Odometry& odometry, Stamp received) {
  OdometryResult result;
  if (!odometry.odom_from_base.isFinite()) return {FilterStatus::kNotFinite, {}};
  if (params_.filter.twist_source == "encoders") {
    result.filter = filter_.addEncoders(odometry.stamp, twistOf(odometry), received);
    noticeJump();
    if (result.filter == FilterStatus::kFromFuture || result.filter == FilterStatus::kTooOld) return result;
  } else if (odometry.stamp > received + fromSeconds(params_.filter.future_tolerance_s)) {
    return {FilterStatus::kFromFuture, {}};
  }
  if (!last_odometry_ || odometry.stamp > last_odometry_->stamp) last_odometry_ = odometry;
  if (const std::optional<PoseEstimate> estimate = takePose(odometry.stamp))
    result.pose = MapPose{*estimate, estimate->map_from_base * odometry.odom_from_base.inverse()};
  return result;
}

std::optional<PoseEstimate> MarkerLocalization::poseWithoutOdometry(Stamp stamp) {
  const Duration timeout = fromSeconds(params_.filter.input_timeout_s);
  if (last_odometry_ && stamp < last_odometry_->stamp + timeout) return std::nullopt;
  return takePose(stamp);
}

/// By the way since the odometry before, unless that is long past or the odometry has jumped.
Twist2 MarkerLocalization::twistOf(const Odometry& odometry) const {
  if (!last_odometry_ || odometry.stamp <= last_odometry_->stamp) return odometry.twist;
  if (odometry.stamp - last_odometry_->stamp > fromSeconds(params_.filter.input_timeout_s))
    return odometry.twist;
  constexpr double kJump_mps = 1.0;
  constexpr double kJump_radps = 3.0;
  const Twist2 mean = meanTwist(*last_odometry_, odometry);
  const bool is_smooth = std::abs(mean.v_mps - odometry.twist.v_mps) < kJump_mps &&
                         std::abs(mean.w_radps - odometry.twist.w_radps) < kJump_radps;
  return is_smooth ? mean : odometry.twist;
}

FilterStatus MarkerLocalization::addCommand(Stamp stamp, const Twist2& twist, Stamp received) {
  const FilterStatus status = filter_.addCommand(stamp, twist, received);
  noticeJump();
  return status;
}

FilterStatus MarkerLocalization::addGyro(Stamp stamp, double rate_radps, Stamp received) {
  const FilterStatus status = filter_.addGyro(stamp, rate_radps, received);
  noticeJump();
  return status;
}

MarkerImageResult MarkerLocalization::addImage(const MarkerCamera& taken, const cv::Mat& image,
                                               Stamp received) {
  return addCorners(taken, detector_.detect(image), received);
}

MarkerImageResult MarkerLocalization::addCorners(const MarkerCamera& taken, const MarkerFindings& findings,
                                                 Stamp received) {
  MarkerImageResult result;
  result.stamp = taken.stamp;
  result.unlisted_ids = findings.unlisted_ids;
  result.fault = findings.fault.empty() ? faultOf(taken, received) : findings.fault;
  if (!result.fault.empty()) return result;
  result.fix = localizerFor(taken).locate(findings.markers, predictedAt(taken.stamp));
  if (!result.fix.isGood()) return result;
  result.filter = filter_.addPose(taken.stamp, {result.fix.map_from_base, result.fix.covariance}, received);
  noticeJump();
  if (result.isUsed()) last_fix_ = last_fix_ ? std::max(*last_fix_, taken.stamp) : taken.stamp;
  return result;
}

/// Where the robot is expected, unless its heading is too uncertain to tell a marker's two poses apart.
std::optional<Pose2> MarkerLocalization::predictedAt(Stamp stamp) const {
  const std::optional<PoseEstimate> estimate = filter_.estimateAt(stamp);
  const double limit_rad = params_.localizer.pose.max_prediction_error_deg * M_PI / 180.0;
  if (!estimate || 2.0 * std::sqrt(estimate->covariance(2, 2)) > limit_rad) return std::nullopt;
  return estimate->map_from_base;
}

FilterStatus MarkerLocalization::setPose(Stamp stamp, const PoseFix& fix, Stamp received) {
  const FilterStatus status = filter_.setPose(stamp, fix, received);
  noticeJump();
  if (status == FilterStatus::kUsed) last_set_ = last_set_ ? std::max(*last_set_, stamp) : stamp;
  return status;
}

void MarkerLocalization::reset() {
  filter_.reset();
  noticeJump();
}

void MarkerLocalization::setParams(const MarkerLocalizationParams& params) {
  validate(params, "marker localization");
  MarkerDetector detector(withDictionary(params.detector, map_), map_.whitelist);
  filter_.setParams(params.filter);
  detector_ = std::move(detector);
  params_ = params;
  localizer_.reset();
}

LocalizationStatus MarkerLocalization::status(Stamp now) const {
  LocalizationStatus status;
  if (const auto estimate = filter_.estimateAt(now)) {
    status.source = estimate->source;
    status.sigma_m = worstSigma(estimate->covariance);
    // One of the two has made the estimate; an empty optional is less than any stamp.
    status.without_markers_s = std::max(0.0, toSeconds(now - *std::max(last_fix_, last_set_)));
    const bool sees = last_fix_ && now <= *last_fix_ + fromSeconds(params_.without_markers_s);
    const bool is_lost = status.sigma_m > params_.max_sigma_m;
    status.state = is_lost ? State::kLost : sees ? State::kMarkers : State::kWithoutMarkers;
  }
  status.reason = inWords(status);
  return status;
}

/// The estimate at a stamp after the last one that was given out.
std::optional<PoseEstimate> MarkerLocalization::takePose(Stamp stamp) {
  if (last_pose_ && stamp <= *last_pose_) return std::nullopt;
  std::optional<PoseEstimate> estimate = filter_.estimateAt(stamp);
  if (estimate) last_pose_ = stamp;
  return estimate;
}

const MarkerLocalizer& MarkerLocalization::localizerFor(const MarkerCamera& taken) {
  const bool is_same =
      taken.camera == camera_ && taken.base_from_optical.matrix() == base_from_optical_.matrix();
  if (!localizer_ || !is_same) {
    localizer_.emplace(params_.localizer, map_, taken.camera, taken.base_from_optical);
    camera_ = taken.camera;
    base_from_optical_ = taken.base_from_optical;
  }
  return *localizer_;
}

std::string MarkerLocalization::faultOf(const MarkerCamera& taken, Stamp received) const {
  if (taken.stamp > received + fromSeconds(params_.filter.future_tolerance_s))
    return toText(FilterStatus::kFromFuture);
  if (!taken.base_from_optical.matrix().allFinite()) return "the camera's pose on the robot is not finite";
  return taken.camera.fault();
}

/// The filter has started anew: so does what belongs to it.
void MarkerLocalization::noticeJump() {
  if (filter_.counts().time_jumps == time_jumps_) return;
  time_jumps_ = filter_.counts().time_jumps;
  last_odometry_.reset();
  last_pose_.reset();
  last_fix_.reset();
  last_set_.reset();
}

}  // namespace frugal_nav
