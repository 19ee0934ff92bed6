#include <cmath>
#include <cstdlib>
#include <utility>

#include <frugal_nav/perception/goal_finder.hpp>

namespace frugal_nav {
namespace {

std::string sizeText(int width_px, int height_px) {
  return std::to_string(width_px) + "x" + std::to_string(height_px);
}

std::string faultOf(const GoalView& view) {
  std::string fault = imageFault(view.bgr);
  if (fault.empty()) fault = exposureFault(view.bgr);
  if (fault.empty()) fault = view.camera.fault();
  if (!fault.empty()) return fault;
  if (!view.odom_from_base.isFinite()) return "the odometry is not finite";
  // A resized image keeps its shape, to a row of rounding; a cropped one has another principal point.
  const int rows = static_cast<int>(
      std::lround(static_cast<double>(view.bgr.cols) * view.camera.height_px / view.camera.width_px));
  if (std::abs(rows - view.bgr.rows) > 1) {
    return "the image is " + sizeText(view.bgr.cols, view.bgr.rows) + ", but its camera is calibrated for " +
           sizeText(view.camera.width_px, view.camera.height_px);
  }
  return {};
}

}  // namespace

GoalFinder::GoalFinder(std::unique_ptr<Detector> detector, const HeadRangeParams& range,
                       const GoalTrackerParams& tracker)
    : detector_(std::move(detector)), range_params_(range), tracker_(tracker) {
  validate(range, "head range");
}

void GoalFinder::setParams(const HeadRangeParams& range, const GoalTrackerParams& tracker) {
  validate(range, "head range");
  tracker_ = GoalTracker(tracker);
  range_params_ = range;
}

GoalFrame GoalFinder::look(const GoalView& view) {
  GoalFrame frame;
  frame.fault = faultOf(view);
  bool could_see = true;
  if (frame.fault.empty()) {
    const HeadRange range(range_params_, view.camera.scaled(view.bgr.cols, view.bgr.rows),
                          view.base_from_optical);
    frame.detections = detector_->detect(view.bgr);
    for (const Detection& detection : frame.detections) frame.sightings.push_back(range.locate(detection));
    const std::optional<TrackedGoal> known = tracker_.goal();
    could_see = !known || range.couldSee(view.odom_from_base.inverse() * known->p_odom, known->above_floor_m);
  }
  frame.state = tracker_.update(view.stamp, view.odom_from_base, frame.sightings, could_see);
  frame.goal = tracker_.goal();
  return frame;
}

}  // namespace frugal_nav
