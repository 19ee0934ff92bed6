#pragma once

#include <frugal_nav/perception/closer_look.hpp>
#include <frugal_nav/perception/detector_choice.hpp>
#include <frugal_nav/perception/feet_range.hpp>
#include <frugal_nav/perception/goal_tracker.hpp>
#include <frugal_nav/perception/head_range.hpp>
#include <frugal_nav/ros/intake_params.hpp>

namespace frugal_nav {

/// Parameters of the node goal_detector: config/goal_detector.yaml. This header needs no ROS.
struct GoalDetectorNodeParams {
  ImageIntakeParams intake;
  DetectorChoice detector;
  HeadRangeParams head;
  GoalTrackerParams tracker;
  FeetParams feet;
  CloserLookParams closer_look;

  template <class Visitor>
  void fields(Visitor&& visit) {
    intake.fields(visit);
    detector.fields(visit);
    visit("head", head);
    visit("tracker", tracker);
    visit("feet", feet);
    visit("closer_look", closer_look);
  }
};

}  // namespace frugal_nav
