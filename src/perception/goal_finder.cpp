#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include <frugal_nav/perception/goal_finder.hpp>
#include <frugal_nav/perception/image_fault.hpp>

namespace frugal_nav {
namespace {

// Images whose surfaces may still come: the pipeline is a few images behind at most.
constexpr std::size_t kAwaited = 8;
// Feet seen in two images that lie nearer to each other are the same.
constexpr double kSameFeet_m = 0.15;
// While nobody is known, persons this far away are looked for most closely: nearer ones are large.
constexpr double kFar_m = 6.0;
// A factor that differs by less is the same.
constexpr double kSameFactor = 0.02;

/// The sound sighting of the goal's class that is nearest to it.
std::optional<std::size_t> nearestSighting(const GoalFrame& frame, const Pose2& odom_from_base) {
  std::optional<std::size_t> nearest;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < frame.sightings.size(); ++i) {
    const HeadSighting& sighting = frame.sightings[i];
    if (sighting.status != HeadSighting::Status::kGood || sighting.class_id != frame.goal->class_id) continue;
    const double off_m = (odom_from_base * sighting.p_base - frame.goal->p_odom).norm();
    if (off_m >= nearest_m) continue;
    nearest_m = off_m;
    nearest = i;
  }
  return nearest;
}

}  // namespace

GoalFinder::GoalFinder(std::unique_ptr<Detector> detector, const HeadRangeParams& range,
                       const GoalTrackerParams& tracker, const HeadCalibrationParams& calibration,
                       const CloserLookParams& closer_look)
    : detector_(std::move(detector)),
      range_params_(range),
      tracker_(tracker),
      calibration_(calibration),
      closer_look_(closer_look) {
  validate(range, "head range");
}

void GoalFinder::setParams(const HeadRangeParams& range, const GoalTrackerParams& tracker,
                           const HeadCalibrationParams& calibration, const CloserLookParams& closer_look) {
  validate(range, "head range");
  const HeadCalibration wanted(calibration);
  closer_look_ = CloserLook(closer_look);
  tracker_ = GoalTracker(tracker);
  calibration_ = wanted;
  range_params_ = range;
  reset();
}

void GoalFinder::reset() {
  tracker_.reset();
  calibration_.reset();
  head_factor_ = 1.0;
  placed_ = false;
  p_odom_feet_.reset();
  looks_.clear();
}

HeadRangeParams GoalFinder::calibratedRange() const {
  HeadRangeParams range = range_params_;
  range.head_height_m *= head_factor_;
  range.head_depth_m *= head_factor_;
  return range;
}

std::vector<cv::Rect> GoalFinder::partsToEnlarge(const GoalView& view, const HeadRange& range,
                                                 bool could_see) const {
  if (!closer_look_.params().enabled) return {};
  const cv::Size image = view.bgr.size();
  const Eigen::Isometry3d optical_from_base = view.base_from_optical.inverse();
  // The middle of a person, so that the body, which tells a head from a ball, is in view with it.
  const auto middle = [&](const Eigen::Vector2d& p_base, double head_above_floor_m) {
    return Eigen::Vector3d(optical_from_base *
                           Eigen::Vector3d(p_base.x(), p_base.y(), 0.5 * head_above_floor_m));
  };
  const std::optional<TrackedGoal> goal = tracker_.goal();
  if (!goal) {
    const double head_m = 0.5 * (range_params_.min_above_floor_m + range_params_.max_above_floor_m);
    const auto center_px = range.camera().project(middle({kFar_m, 0.0}, head_m));
    return closer_look_.across(image, center_px ? center_px->y() : 0.5 * image.height);
  }
  if (!could_see) return {};
  const Eigen::Vector3d p_optical = middle(view.odom_from_base.inverse() * goal->p_odom, goal->above_floor_m);
  const auto center_px = range.camera().project(p_optical);
  const double height_px = range.camera().fy * range_params_.head_height_m / p_optical.z();
  if (!center_px || height_px > closer_look_.params().max_height_share * image.height) return {};
  return {closer_look_.around(image, {center_px->x(), center_px->y()})};
}

GoalFrame GoalFinder::look(const GoalView& view) {
  GoalFrame frame;
  frame.fault = viewFault(view.bgr, view.camera, view.odom_from_base);
  bool could_see = true;
  if (frame.fault.empty()) {
    const HeadRange range(calibratedRange(), view.camera.scaled(view.bgr.cols, view.bgr.rows),
                          view.base_from_optical);
    const std::optional<TrackedGoal> known = tracker_.goal();
    could_see = !known || range.couldSee(view.odom_from_base.inverse() * known->p_odom, known->above_floor_m);
    frame.detections = CloserLook::add(detector_->detect(view.bgr), view.bgr,
                                       partsToEnlarge(view, range, could_see), *detector_);
    for (const Detection& detection : frame.detections) frame.sightings.push_back(range.locate(detection));
  }
  frame.state = tracker_.update(view.stamp, view.odom_from_base, frame.sightings, could_see);
  frame.goal = tracker_.goal();
  frame.observed = frame.goal && (frame.state == GoalTracker::State::kSeen || placed_);
  placed_ = false;
  if (!frame.goal) {  // the next one has a head of its own
    calibration_.reset();
    head_factor_ = 1.0;
    looks_.clear();
  }
  if (looks_.size() >= kAwaited) looks_.pop_front();
  if (frame.state == GoalTracker::State::kUnseen && !could_see) {
    looks_.push_back({view.stamp, view.odom_from_base, std::nullopt});
    return frame;
  }
  p_odom_feet_.reset();
  if (frame.state != GoalTracker::State::kSeen) return frame;
  frame.goal_detection = nearestSighting(frame, view.odom_from_base);
  if (!frame.goal_detection) return frame;
  HeadSighting head = frame.sightings[*frame.goal_detection];
  head.range_m /= head_factor_;
  looks_.push_back({view.stamp, view.odom_from_base, head});
  return frame;
}

void GoalFinder::addSurfaces(const LaserScan& surfaces) {
  const auto found = std::find_if(looks_.begin(), looks_.end(),
                                  [&](const Look& look) { return look.stamp == surfaces.stamp; });
  if (found == looks_.end() || !calibration_.params().enabled) return;
  if (found->head) {
    calibrate(*found->head, surfaces);
  } else {
    placeBySurfaces(found->odom_from_base, surfaces);
  }
}

void GoalFinder::calibrate(const HeadSighting& head, const LaserScan& surfaces) {
  calibration_.add(head, surfaces);
  const double change = calibration_.factor() / head_factor_ - 1.0;
  if (std::abs(change) < kSameFactor) return;
  head_factor_ = calibration_.factor();
  tracker_.doubt(change * head.range_m);  // its place came from the other size
}

void GoalFinder::placeBySurfaces(const Pose2& odom_from_base, const LaserScan& surfaces) {
  const std::optional<TrackedGoal> goal = tracker_.goal();
  if (!goal) return;
  const Eigen::Vector2d p_base = odom_from_base.inverse() * goal->p_odom;
  const double bearing_rad = std::atan2(p_base.y(), p_base.x());
  const std::optional<double> range_m =
      bodyRange(bearing_rad, p_base.norm(), surfaces, calibration_.params());
  if (!range_m || !standsFree(bearing_rad, *range_m, surfaces, calibration_.params())) {
    p_odom_feet_.reset();
    return;
  }
  const double yaw_rad = odom_from_base.yaw_rad + bearing_rad;
  const Eigen::Vector2d along(std::cos(yaw_rad), std::sin(yaw_rad));
  const Eigen::Vector2d p_odom = odom_from_base.position() + *range_m * along;
  const bool agrees = p_odom_feet_ && (p_odom - *p_odom_feet_).norm() < kSameFeet_m;
  p_odom_feet_ = p_odom;
  if (!agrees) return;  // one image may mistake something else for them
  const Eigen::Vector2d aside(-along.y(), along.x());
  const double along_m = calibration_.params().body_sigma_m;
  const double aside_m = calibration_.params().half_width_m;
  placed_ = tracker_.place(
      p_odom, along_m * along_m * along * along.transpose() + aside_m * aside_m * aside * aside.transpose());
}

}  // namespace frugal_nav
