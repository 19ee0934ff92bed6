#include <algorithm>
#include <cmath>

#include <frugal_nav/odometry/visual_estimator.hpp>

namespace frugal_nav {
namespace {

constexpr double kMinTurn_rad = 0.03;           // a turn worth naming: an image or two of turning on the spot
constexpr double kSmallTurn_rad = 0.2;          // up to it a wheel distance is good for the scale
constexpr double kStartTurn_rad = 0.5;          // beyond it two views share too little
constexpr double kAnchorShare = 0.4;            // of the anchor's features that must still be followed
constexpr double kKeyframeShare = 0.65;         // of the last keyframe's map points, below which one is due
constexpr double kUnscaledBaseline = 0.1;       // way between the first two views when nobody knows it
constexpr double kStartTurnError_rad = 0.06;    // wheels against images over a start's baseline
constexpr double kStartCourseError_rad = 0.35;  // and their courses
constexpr double kAdjustedCourseError_rad = 0.08;  // once all features have been adjusted
constexpr double kJumpShare = 2.0;                 // visual over wheel motion of one image
constexpr double kJump_m = 0.05;                   // that is not believed
constexpr int kDisagreements = 5;     // scale samples before wheels and images are said to disagree
constexpr double kStraySigmas = 3.0;  // of the scale

}  // namespace

VisualEstimator::VisualEstimator(const VisualOdometryParams& params, double focal_px,
                                 const Eigen::Isometry3d& base_from_camera)
    : params_(params),
      focal_px_(focal_px),
      base_from_camera_(base_from_camera),
      map_(params.map, focal_px),
      scale_(static_cast<std::size_t>(params.motion.scale_samples)),
      stray_(params.checks, focal_px) {}

void VisualEstimator::reset() { *this = VisualEstimator(params_, focal_px_, base_from_camera_); }

void VisualEstimator::setFocal(double focal_px) {
  dropMap();
  focal_px_ = focal_px;
  map_ = VisualMap(params_.map, focal_px);
  stray_ = VisualStrayWatch(params_.checks, focal_px);
}

std::optional<Eigen::Isometry3d> VisualEstimator::wheelMotion(
    const std::optional<Eigen::Isometry3d>& wheels_from_camera) const {
  if (params_.motion.wheels != "motion" || !last_wheels_ || !wheels_from_camera) return std::nullopt;
  return last_wheels_->inverse() * *wheels_from_camera;
}

void VisualEstimator::predict() {
  if (!has_pose_ && wheels_from_camera_) {
    // The first pose: the wheels'. Where they give distances only, any will do.
    odom_from_camera_ = params_.motion.wheels == "motion" ? *wheels_from_camera_ : base_from_camera_;
  } else if (!has_pose_) {
    odom_from_camera_ = base_from_camera_;
  } else if (const auto motion = wheelMotion(wheels_from_camera_)) {
    odom_from_camera_ = odom_from_camera_ * *motion;
  } else if (!map_.empty()) {
    odom_from_camera_ = odom_from_camera_ * last_motion_;
  }
  has_pose_ = true;
}

VisualUpdate VisualEstimator::update(const RayMap& rays,
                                     const std::optional<Eigen::Isometry3d>& wheels_from_camera) {
  const Eigen::Isometry3d before = odom_from_camera_;
  const bool had_pose = has_pose_;
  wheels_from_camera_ = wheels_from_camera;
  predict();
  VisualUpdate update;
  if (map_.empty()) {
    update = withoutMap(rays);
  } else {
    update = track(rays);
    if (update.state == VisualState::kLost) {
      dropMap();
      setAnchor(rays);
    }
  }
  last_motion_ = had_pose ? before.inverse() * odom_from_camera_ : Eigen::Isometry3d::Identity();
  last_wheels_ = wheels_from_camera_;
  return update;
}

void VisualEstimator::lose(const std::optional<Eigen::Isometry3d>& wheels_from_camera) {
  dropMap();
  wheels_from_camera_ = wheels_from_camera;
  predict();
  if (wheels_from_camera) last_wheels_ = wheels_from_camera;
}

void VisualEstimator::dropMap() {
  map_.clear();
  anchor_.reset();
  stray_.reset();
  last_motion_ = Eigen::Isometry3d::Identity();
}

Eigen::Isometry3d VisualEstimator::flattened(const Eigen::Isometry3d& odom_from_camera) const {
  if (!params_.motion.planar) return odom_from_camera;
  const Eigen::Isometry3d odom_from_base = odom_from_camera * base_from_camera_.inverse();
  Eigen::Isometry3d flat = Eigen::Isometry3d::Identity();
  flat.translation() << odom_from_base.translation().x(), odom_from_base.translation().y(), 0.0;
  const Eigen::Vector3d ahead = odom_from_base.linear().col(0);
  flat.linear() = Eigen::AngleAxisd(std::atan2(ahead.y(), ahead.x()), Eigen::Vector3d::UnitZ()).matrix();
  return flat * base_from_camera_;
}

std::optional<PlanarPrior> VisualEstimator::planarPrior() const {
  if (!params_.motion.planar) return std::nullopt;
  return PlanarPrior{base_from_camera_.inverse(), params_.motion.planar_sigma_m,
                     params_.motion.planar_sigma_rad};
}

BundleSettings VisualEstimator::bundleSettings() const {
  BundleSettings settings;
  settings.focal_px = focal_px_;
  settings.window = static_cast<std::size_t>(params_.map.window);
  settings.wheel_sigma = params_.motion.wheel_sigma;
  settings.wheel_sigma_m = params_.motion.wheel_sigma_m;
  settings.planar = planarPrior();
  return settings;
}

void VisualEstimator::setAnchor(const RayMap& rays) {
  odom_from_camera_ = flattened(odom_from_camera_);
  anchor_ = Anchor{odom_from_camera_, wheels_from_camera_, rays, 0};
}

bool VisualEstimator::isThin(const SharedRays& shared) const {
  return static_cast<double>(shared.ids.size()) < kAnchorShare * static_cast<double>(anchor_->most_shared);
}

VisualUpdate VisualEstimator::withoutMap(const RayMap& rays) {
  VisualUpdate update;
  if (!anchor_) {
    setAnchor(rays);
    update.reason = VisualReason::kFirstImage;
    return update;
  }
  const SharedRays shared = sharedBetween(anchor_->rays, rays);
  const auto turn = fitRotation(shared.before, shared.now, focal_px_, params_.checks.rotation_residual_px);
  if (!turn || static_cast<int>(shared.ids.size()) < params_.checks.min_features) {
    setAnchor(rays);
    update.reason = VisualReason::kFewFeatures;
    return update;
  }
  // Of the anchor's features only those count that could be followed at all.
  anchor_->most_shared = std::max(anchor_->most_shared, shared.ids.size());
  update.inliers = turn->inliers;
  if (turn->median_residual_px <= params_.checks.rotation_residual_px) return turnOnly(rays, shared, *turn);
  update.reason = VisualReason::kNoParallax;
  if (turn->median_residual_px >= params_.map.min_start_parallax_px) {
    update.reason = tryStart(rays, shared, update.inliers);
    if (update.reason == VisualReason::kNone || update.reason == VisualReason::kNoWheels) {
      update.state = VisualState::kTracking;
      update.is_keyframe = true;
      return update;
    }
  }
  const double turned_rad = Eigen::AngleAxisd(turn->b_from_a).angle();
  if (isThin(shared) || turned_rad > kStartTurn_rad) setAnchor(rays);
  return update;
}

VisualUpdate VisualEstimator::turnOnly(const RayMap& rays, const SharedRays& shared,
                                       const RotationFit& turn) {
  VisualUpdate update;
  update.inliers = turn.inliers;
  const double turned_rad = Eigen::AngleAxisd(turn.b_from_a).angle();
  update.state = turned_rad > kMinTurn_rad ? VisualState::kRotating : VisualState::kInitializing;
  update.reason = VisualReason::kNoParallax;
  // The images tell the direction; the position stays the wheels'. Standing or driving ahead it stays theirs
  // too: what little flow there is would be taken for a turn.
  if (update.state == VisualState::kRotating)
    odom_from_camera_.linear() = anchor_->odom_from_camera.linear() * turn.b_from_a.transpose();
  if (isThin(shared)) setAnchor(rays);
  return update;
}

bool VisualEstimator::agreesWithWheels(const Eigen::Isometry3d& anchor_from_now,
                                       double course_error_rad) const {
  if (params_.motion.wheels != "motion" || !anchor_->wheels_from_camera || !wheels_from_camera_) return true;
  const Eigen::Isometry3d wheels = anchor_->wheels_from_camera->inverse() * *wheels_from_camera_;
  if (turnOf(wheels.inverse() * anchor_from_now) > kStartTurnError_rad + 0.1 * turnOf(wheels)) return false;
  const double cosine = wheels.translation().normalized().dot(anchor_from_now.translation().normalized());
  return cosine > std::cos(course_error_rad);
}

VisualReason VisualEstimator::tryStart(const RayMap& rays, const SharedRays& shared, int& inliers) {
  double baseline_m = kUnscaledBaseline;
  const bool has_wheels = anchor_->wheels_from_camera && wheels_from_camera_;
  if (has_wheels) {
    baseline_m = (anchor_->wheels_from_camera->inverse() * *wheels_from_camera_).translation().norm();
    if (baseline_m < params_.map.min_baseline_m) return VisualReason::kShortBaseline;
  }
  const auto motion = findTwoViewMotion(shared.before, shared.now, focal_px_, 1.0);
  if (!motion || motion->inliers < params_.map.min_start_points) return VisualReason::kRansacFailed;
  if (!agreesWithWheels(motion->a_from_b, kStartCourseError_rad)) return VisualReason::kWheelsDisagree;
  inliers = motion->inliers;
  Eigen::Isometry3d anchor_from_now = motion->a_from_b;
  anchor_from_now.translation() *= baseline_m;

  Keyframe first{anchor_->odom_from_camera, anchor_->wheels_from_camera, {}};
  Keyframe second{anchor_->odom_from_camera * anchor_from_now, wheels_from_camera_, rays};
  for (std::size_t i = 0; i < shared.ids.size(); ++i) {
    if (motion->is_inlier[i] != 0) {
      first.rays[shared.ids[i]] = shared.before[i];
    } else {
      second.rays.erase(shared.ids[i]);
    }
  }
  map_.addKeyframe(std::move(first));
  map_.addKeyframe(std::move(second));
  map_.triangulateNew();
  if (static_cast<int>(map_.landmarks().size()) >= params_.map.min_start_points) {
    adjustBundle(map_, bundleSettings());
    map_.clean();
    // The adjustment may have gone astray with a few wrong features.
    const Keyframe& from = map_.keyframes().front();
    if (!agreesWithWheels(from.odom_from_camera.inverse() * map_.keyframes().back().odom_from_camera,
                          kAdjustedCourseError_rad)) {
      map_.clear();
      return VisualReason::kWheelsDisagree;
    }
  }
  if (static_cast<int>(map_.landmarks().size()) < params_.map.min_start_points) {
    map_.clear();
    return VisualReason::kNoParallax;
  }
  odom_from_camera_ = map_.keyframes().back().odom_from_camera;
  keyframe_inliers_ = static_cast<int>(map_.landmarks().size());
  is_metric_ = has_wheels;
  scale_.clear();
  if (has_wheels)
    scale_.add(
        baseline_m,
        (map_.keyframes().front().odom_from_camera.translation() - odom_from_camera_.translation()).norm());
  anchor_.reset();
  return has_wheels ? VisualReason::kNone : VisualReason::kNoWheels;
}

VisualUpdate VisualEstimator::track(const RayMap& rays) {
  VisualUpdate update;
  update.state = VisualState::kTracking;
  update.reason = is_metric_ ? VisualReason::kNone : VisualReason::kNoWheels;
  PoseFit fit;
  const VisualReason fault = findPoseInMap(rays, update, fit);
  if (fault != VisualReason::kNone) {
    update.state = VisualState::kLost;
    update.reason = fault;
    return update;
  }
  odom_from_camera_ = fit.world_from_camera;
  if (straysFromWheels(rays)) {
    update.state = VisualState::kLost;
    update.reason = VisualReason::kWheelsDisagree;
    return update;
  }
  update.covariance = fit.covariance;
  update.inliers = fit.inliers;
  if (needsKeyframe(fit.inliers)) {
    addKeyframe(rays);
    update.is_keyframe = true;
    const auto scale = scale_.estimate();
    const double limit = params_.motion.max_scale_ratio;
    if (scale && is_metric_ && scale->samples >= kDisagreements &&
        (scale->scale > limit || scale->scale * limit < 1.0)) {
      update.state = VisualState::kLost;
      update.reason = VisualReason::kWheelsDisagree;
    }
  }
  return update;
}

VisualReason VisualEstimator::findPoseInMap(const RayMap& rays, VisualUpdate& update, PoseFit& fit) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Ray2> seen;
  for (const auto& [id, ray] : rays) {
    const auto landmark = map_.landmarks().find(id);
    if (landmark == map_.landmarks().end()) continue;
    points.push_back(landmark->second.p_odom);
    seen.push_back(ray);
  }
  update.inliers = static_cast<int>(points.size());
  if (update.inliers < params_.checks.min_inliers) return VisualReason::kFewMapPoints;
  const double least = std::max(static_cast<double>(params_.checks.min_inliers),
                                params_.checks.min_inlier_share * static_cast<double>(points.size()));
  const auto isGood = [&](const std::optional<PoseFit>& found) {
    return found && found->inliers >= least && !isTooFarFromWheels(found->world_from_camera);
  };
  const double limit_px = params_.map.max_reprojection_px;
  auto found = refinePose(points, seen, odom_from_camera_, focal_px_, limit_px, planarPrior());
  if (!isGood(found)) {
    // The prediction did not lead there: RANSAC needs none.
    const auto guess = findPose(points, seen, focal_px_, limit_px);
    if (guess) found = refinePose(points, seen, *guess, focal_px_, limit_px, planarPrior());
    if (!guess || !isGood(found)) return VisualReason::kRansacFailed;
  }
  fit = *found;
  return VisualReason::kNone;
}

bool VisualEstimator::isTooFarFromWheels(const Eigen::Isometry3d& odom_from_camera) const {
  const auto motion = wheelMotion(wheels_from_camera_);
  if (!motion || !is_metric_) return false;
  // odom_from_camera_ is the wheels' prediction here.
  const double apart_m = (odom_from_camera.translation() - odom_from_camera_.translation()).norm();
  return apart_m > kJump_m + kJumpShare * motion->translation().norm();
}

/// Gives the pose back to the wheels when it has gone astray.
bool VisualEstimator::straysFromWheels(const RayMap& rays) {
  const auto step = wheelMotion(wheels_from_camera_);
  if (!step || !is_metric_) {
    stray_.pause();
    return false;
  }
  const auto instead = stray_.check(odom_from_camera_, *wheels_from_camera_, *step, rays);
  if (instead) odom_from_camera_ = *instead;
  return instead.has_value();
}

bool VisualEstimator::needsKeyframe(int inliers) const {
  const Eigen::Isometry3d motion = map_.keyframes().back().odom_from_camera.inverse() * odom_from_camera_;
  const double moved_m = motion.translation().norm();
  const double turned_rad = turnOf(motion);
  const double depth_m = map_.medianDepth().value_or(1.0);
  double step_m = params_.map.keyframe_depth_share * depth_m;
  if (is_metric_) step_m = std::max(step_m, params_.map.keyframe_distance_m);
  if (moved_m > step_m || turned_rad > params_.map.keyframe_turn_rad) return true;
  const bool is_thin = inliers < kKeyframeShare * keyframe_inliers_;
  return is_thin && (moved_m > 0.25 * step_m || turned_rad > kMinTurn_rad);
}

void VisualEstimator::addKeyframe(const RayMap& rays) {
  map_.addKeyframe({odom_from_camera_, wheels_from_camera_, rays});
  sampleScale();
  map_.triangulateNew();
  if (adjustBundle(map_, bundleSettings()).is_usable)
    odom_from_camera_ = map_.keyframes().back().odom_from_camera;
  map_.clean();
  keyframe_inliers_ = 0;
  for (const auto& [id, ray] : map_.keyframes().back().rays)
    keyframe_inliers_ += map_.landmarks().count(id) != 0 ? 1 : 0;
}

void VisualEstimator::sampleScale() {
  const Keyframe& now = map_.keyframes().back();
  if (!now.wheels_from_camera) return;
  // The nearest keyframe that is far enough; before the adjustment, which draws distances to the wheels'.
  for (auto other = map_.keyframes().rbegin() + 1; other != map_.keyframes().rend(); ++other) {
    if (!other->wheels_from_camera) return;
    const Eigen::Isometry3d wheels = other->wheels_from_camera->inverse() * *now.wheels_from_camera;
    const Eigen::Isometry3d seen = other->odom_from_camera.inverse() * now.odom_from_camera;
    if (turnOf(seen) > kSmallTurn_rad) return;
    if (wheels.translation().norm() < params_.map.min_baseline_m || seen.translation().norm() < 1e-6)
      continue;
    scale_.add(wheels.translation().norm(), seen.translation().norm());
    break;
  }
  const auto scale = scale_.estimate();
  if (!is_metric_ && scale && scale->samples >= kDisagreements &&
      std::abs(scale->scale - 1.0) > kStraySigmas * scale->sigma) {
    // The wheels came late: the map becomes metric now.
    map_.rescale(scale->scale, odom_from_camera_.translation());
    scale_.clear();
  }
  is_metric_ = is_metric_ || (scale && scale->samples >= kDisagreements);
}

}  // namespace frugal_nav
