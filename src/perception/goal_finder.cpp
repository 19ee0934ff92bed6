#include <algorithm>
#include <cmath>
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

}  // namespace

GoalFinder::GoalFinder(std::unique_ptr<Detector> detector, const HeadRangeParams& range,
                       const GoalTrackerParams& tracker, const FeetParams& feet,
                       const CloserLookParams& closer_look)
    : detector_(std::move(detector)),
      range_params_(range),
      tracker_(tracker),
      feet_(feet),
      closer_look_(closer_look) {
  validate(range, "head range");
  validate(feet, "feet");
}

void GoalFinder::setParams(const HeadRangeParams& range, const GoalTrackerParams& tracker,
                           const FeetParams& feet, const CloserLookParams& closer_look) {
  validate(range, "head range");
  validate(feet, "feet");
  closer_look_ = CloserLook(closer_look);
  tracker_ = GoalTracker(tracker);
  feet_ = feet;
  range_params_ = range;
  reset();
}

void GoalFinder::reset() {
  tracker_.reset();
  placed_ = false;
  p_odom_feet_.reset();
  looks_.clear();
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
    const HeadRange range(range_params_, view.camera.scaled(view.bgr.cols, view.bgr.rows),
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
  frame.goal_detection = tracker_.seenBy();
  if (!frame.goal) looks_.clear();
  if (looks_.size() >= kAwaited) looks_.pop_front();
  if (frame.state == GoalTracker::State::kSeen || (frame.goal && !could_see)) {
    looks_.push_back({view.stamp, view.odom_from_base});
  } else {
    p_odom_feet_.reset();
  }
  return frame;
}

void GoalFinder::addSurfaces(const LaserScan& surfaces) {
  const auto found = std::find_if(looks_.begin(), looks_.end(),
                                  [&](const Look& look) { return look.stamp == surfaces.stamp; });
  if (found != looks_.end() && feet_.enabled) placeBySurfaces(*found, surfaces);
}

void GoalFinder::placeBySurfaces(const Look& look, const LaserScan& surfaces) {
  const std::optional<TrackedGoal> goal = tracker_.goal();
  if (!goal) return;
  const Eigen::Vector2d p_base = look.odom_from_base.inverse() * goal->p_odom;
  const double bearing_rad = std::atan2(p_base.y(), p_base.x());
  const std::optional<double> range_m = bodyRange(bearing_rad, p_base.norm(), surfaces, feet_);
  if (!range_m || !standsFree(bearing_rad, *range_m, surfaces, feet_)) {
    p_odom_feet_.reset();
    return;
  }
  const double yaw_rad = look.odom_from_base.yaw_rad + bearing_rad;
  const Eigen::Vector2d along(std::cos(yaw_rad), std::sin(yaw_rad));
  const Eigen::Vector2d p_odom = look.odom_from_base.position() + *range_m * along;
  const bool agrees = p_odom_feet_ && (p_odom - *p_odom_feet_).norm() < kSameFeet_m;
  p_odom_feet_ = p_odom;
  if (!agrees) return;  // one image may mistake something else for them
  const Eigen::Vector2d aside(-along.y(), along.x());
  const double along_m = std::hypot(feet_.body_sigma_m, feet_.range_sigma_share * *range_m);
  const double aside_m = feet_.half_width_m;
  placed_ = tracker_.place(
      look.stamp, p_odom,
      along_m * along_m * along * along.transpose() + aside_m * aside_m * aside * aside.transpose());
}

}  // namespace frugal_nav
