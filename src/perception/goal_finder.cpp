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
// A factor that differs by less is the same.
constexpr double kSameFactor = 0.02;

/// The sound sighting nearest to the goal.
std::optional<std::size_t> nearestSighting(const GoalFrame& frame, const Pose2& odom_from_base) {
  std::optional<std::size_t> nearest;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < frame.sightings.size(); ++i) {
    if (frame.sightings[i].status != HeadSighting::Status::kGood) continue;
    const double off_m = (odom_from_base * frame.sightings[i].p_base - frame.goal->p_odom).norm();
    if (off_m >= nearest_m) continue;
    nearest_m = off_m;
    nearest = i;
  }
  return nearest;
}

}  // namespace

GoalFinder::GoalFinder(std::unique_ptr<Detector> detector, const HeadRangeParams& range,
                       const GoalTrackerParams& tracker, const HeadCalibrationParams& calibration)
    : detector_(std::move(detector)), range_params_(range), tracker_(tracker), calibration_(calibration) {
  validate(range, "head range");
}

void GoalFinder::setParams(const HeadRangeParams& range, const GoalTrackerParams& tracker,
                           const HeadCalibrationParams& calibration) {
  validate(range, "head range");
  const HeadCalibration wanted(calibration);
  tracker_ = GoalTracker(tracker);
  calibration_ = wanted;
  range_params_ = range;
  reset();
}

void GoalFinder::reset() {
  tracker_.reset();
  calibration_.reset();
  head_factor_ = 1.0;
  seen_.clear();
}

HeadRangeParams GoalFinder::calibratedRange() const {
  HeadRangeParams range = range_params_;
  range.head_height_m *= head_factor_;
  range.head_depth_m *= head_factor_;
  return range;
}

GoalFrame GoalFinder::look(const GoalView& view) {
  GoalFrame frame;
  frame.fault = viewFault(view.bgr, view.camera, view.odom_from_base);
  bool could_see = true;
  if (frame.fault.empty()) {
    const HeadRange range(calibratedRange(), view.camera.scaled(view.bgr.cols, view.bgr.rows),
                          view.base_from_optical);
    frame.detections = detector_->detect(view.bgr);
    for (const Detection& detection : frame.detections) frame.sightings.push_back(range.locate(detection));
    const std::optional<TrackedGoal> known = tracker_.goal();
    could_see = !known || range.couldSee(view.odom_from_base.inverse() * known->p_odom, known->above_floor_m);
  }
  frame.state = tracker_.update(view.stamp, view.odom_from_base, frame.sightings, could_see);
  frame.goal = tracker_.goal();
  if (!frame.goal) {  // the next one has a head of its own
    calibration_.reset();
    head_factor_ = 1.0;
    seen_.clear();
  }
  if (frame.state != GoalTracker::State::kSeen) return frame;
  frame.goal_detection = nearestSighting(frame, view.odom_from_base);
  if (!frame.goal_detection) return frame;
  HeadSighting head = frame.sightings[*frame.goal_detection];
  head.range_m /= head_factor_;
  seen_.push_back({view.stamp, head});
  if (seen_.size() > kAwaited) seen_.pop_front();
  return frame;
}

void GoalFinder::addSurfaces(const LaserScan& surfaces) {
  const auto found = std::find_if(seen_.begin(), seen_.end(),
                                  [&](const Seen& seen) { return seen.stamp == surfaces.stamp; });
  if (found == seen_.end()) return;
  calibration_.add(found->head, surfaces);
  const double change = calibration_.factor() / head_factor_ - 1.0;
  if (std::abs(change) < kSameFactor) return;
  head_factor_ = calibration_.factor();
  tracker_.doubt(change * found->head.range_m);  // its place came from the other size
}

}  // namespace frugal_nav
