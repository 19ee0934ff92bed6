#pragma once

#include <cmath>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/planning/obstacle_tracker.hpp>

namespace frugal_nav {

struct RightOfWayParams {
  double cruise_mps = 0.25;
  double horizon_s = 5.0;
  double keep_m = 0.30;
  double largest_radius_m = 0.30;
  double early_s = 1.0;
  double late_s = 1.5;
  double speed_sigmas = 1.0;
  double accel_mps2 = 1000.0;
  double leave_m = -10.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit(
        "cruise_mps", cruise_mps,
        Field{"m/s", "the robot's speed along a path, that of base_controller: when it is where", 0.02, 5.0});
    visit("horizon_s", horizon_s, Field{"s", "how far ahead moving obstacles are predicted", 0.5, 30.0});
    visit("keep_m", keep_m, Field{"m", "air between the robot's circle and a moving obstacle's", 0.0, 2.0});
    visit("largest_radius_m", largest_radius_m,
          Field{"m", "a walking person's radius; two seen as one are not larger", 0.05, 2.0});
    visit("early_s", early_s,
          Field{"s", "the robot passes before a moving obstacle only when that comes this much later", 0.0,
                10.0});
    visit("late_s", late_s,
          Field{"s", "and behind it only when it has passed this much before: it may slow down", 0.0, 10.0});
    visit("speed_sigmas", speed_sigmas,
          Field{"", "standard deviations by which its speed and place may differ", 0.0, 5.0});
    visit("accel_mps2", accel_mps2,
          Field{"m/s^2", "how fast the robot gets from its present speed to cruise_mps", 0.05, 1000.0});
    visit(
        "leave_m", leave_m,
        Field{"m",
              "air that a robot already in the way must keep to drive on; with less it stands, lest it drive "
              "into what comes",
              -10.0, 2.0});
  }
};

/// How far the robot may drive along a path without getting in the way of what moves [m]: all of it, or up to
/// where it lets one pass; zero where it should not move at all.
///
/// Obstacles go on at constant velocity; the robot speeds up along the path from `speed_mps`. Where the robot
/// would meet one, the path ends before the strip that obstacle sweeps; a robot that already stands in that
/// strip leaves it if driving on keeps more distance than standing does.
double lengthToYield(const Path2& path, const std::vector<TrackedObstacle>& moving, double robot_radius_m,
                     const RightOfWayParams& params, double speed_mps = HUGE_VAL);

}  // namespace frugal_nav
