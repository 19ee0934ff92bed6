#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/perception/detector.hpp>
#include <frugal_nav/perception/goal_tracker.hpp>
#include <frugal_nav/perception/head_range.hpp>

namespace frugal_nav {

/// One image and what it was taken with.
struct GoalView {
  Stamp stamp{};
  cv::Mat bgr;     ///< CV_8UC3
  Pinhole camera;  ///< of this image, or of the one it was resized from
  Eigen::Isometry3d base_from_optical = Eigen::Isometry3d::Identity();
  Pose2 odom_from_base;  ///< at the stamp
};

/// What one image told about the goal.
struct GoalFrame {
  std::string fault;  ///< why the image could not be used; empty when it was
  std::vector<Detection> detections;
  std::vector<HeadSighting> sightings;  ///< one for each detection
  GoalTracker::State state = GoalTracker::State::kNone;
  std::optional<TrackedGoal> goal;
};

/// The goal from images: detect, locate, track (paper 000, stage 1).
class GoalFinder {
 public:
  /// Throws ConfigError on parameters out of range.
  GoalFinder(std::unique_ptr<Detector> detector, const HeadRangeParams& range,
             const GoalTrackerParams& tracker);

  /// Takes one image. One that cannot be used, or a camera without calibration, counts as nothing seen: the
  /// goal is lost after its time-out and found again when sound images return.
  GoalFrame look(const GoalView& view);

  const Detector& detector() const { return *detector_; }
  /// Other parameters from the next image on; the goal is forgotten. Throws ConfigError when they are bad.
  void setParams(const HeadRangeParams& range, const GoalTrackerParams& tracker);
  /// Forgets the goal.
  void reset() { tracker_.reset(); }

 private:
  std::unique_ptr<Detector> detector_;
  HeadRangeParams range_params_;
  GoalTracker tracker_;
};

}  // namespace frugal_nav
