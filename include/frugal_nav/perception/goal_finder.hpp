#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/perception/closer_look.hpp>
#include <frugal_nav/perception/detector.hpp>
#include <frugal_nav/perception/feet_range.hpp>
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
  bool observed = false;  ///< the goal was seen in this image, or its feet in the last one
  std::optional<std::size_t> goal_detection;  ///< which of them the goal was seen by; set while kSeen
};

/// The goal from images: detect, locate, track (paper 000, stage 1).
class GoalFinder {
 public:
  /// Throws ConfigError on parameters out of range.
  GoalFinder(std::unique_ptr<Detector> detector, const HeadRangeParams& range,
             const GoalTrackerParams& tracker, const FeetParams& feet = {},
             const CloserLookParams& closer_look = {});

  /// Takes one image. One that cannot be used, or a camera without calibration, counts as nothing seen: the
  /// goal is lost after its time-out and found again when sound images return.
  GoalFrame look(const GoalView& view);
  /// The nearest surfaces in the view of an image looked at before, in base_link: where the goal's feet stand
  /// tells its place, and so the size of its head, from the next image on.
  void addSurfaces(const LaserScan& surfaces);

  const Detector& detector() const { return *detector_; }
  /// Other parameters from the next image on; the goal is forgotten. Throws ConfigError when they are bad.
  void setParams(const HeadRangeParams& range, const GoalTrackerParams& tracker, const FeetParams& feet = {},
                 const CloserLookParams& closer_look = {});
  /// Forgets the goal.
  void reset();

 private:
  std::unique_ptr<Detector> detector_;
  std::vector<cv::Rect> partsToEnlarge(const GoalView& view, const HeadRange& range, bool could_see) const;

  HeadRangeParams range_params_;
  GoalTracker tracker_;
  FeetParams feet_;
  CloserLook closer_look_;
  struct Look {
    Stamp stamp{};
    Pose2 odom_from_base;
  };
  void placeBySurfaces(const Look& look, const LaserScan& surfaces);

  bool placed_ = false;                         ///< by its feet, since the last image
  std::optional<Eigen::Vector2d> p_odom_feet_;  ///< where they were seen in the last image
  std::deque<Look> looks_;                      ///< the last images that surfaces may tell more of
};

}  // namespace frugal_nav
