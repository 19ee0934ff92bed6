#pragma once

#include <frugal_nav/perception/depth_choice.hpp>
#include <frugal_nav/perception/depth_gap.hpp>
#include <frugal_nav/ros/intake_params.hpp>

namespace frugal_nav {

/// Parameters of the node depth_gap: config/depth_gap.yaml. This header needs no ROS.
struct DepthGapNodeParams {
  ImageIntakeParams intake;
  DepthChoice network;
  bool use_vo = true;
  double vo_wait_s = 0.25;
  double goal_memory_s = 60.0;
  DepthGapParams depth;

  template <class Visitor>
  void fields(Visitor&& visit) {
    intake.fields(visit);
    network.fields(visit);
    visit(
        "use_vo", use_vo,
        atStart(Field{"", "whether an image waits for vo/points of its stamp; false: floor and goal alone"}));
    visit("vo_wait_s", vo_wait_s,
          Field{"s", "ROS time it waits for them before it goes on without; a newer image ends it too", 0.0,
                5.0});
    visit("goal_memory_s", goal_memory_s,
          Field{"s", "how long the person last told by goal/observed is no obstacle", 0.0, 36000.0});
    depth.fields(visit);
  }
};

}  // namespace frugal_nav
