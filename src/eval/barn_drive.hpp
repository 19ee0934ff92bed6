#pragma once

#include "lidar_drive.hpp"

#include <frugal_nav/common/params.hpp>

namespace frugal_nav::eval {

/// The challenge's rules, and what its robot's base makes of commands.
struct BarnRules {
  double goal_radius_m = 1.0;
  double time_limit_s = 100.0;
  double clock_starts_m = 0.1;
  double control_hz = 20.0;
  double accel_mps2 = 5.0;
  double max_w_radps = 4.0;
  double turn_accel_radps2 = 10.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("goal_radius_m", goal_radius_m, Field{"m", "reached within this, by the truth", 0.1, 5.0});
    visit("time_limit_s", time_limit_s, Field{"s", "failed after this", 1.0, 3600.0});
    visit("clock_starts_m", clock_starts_m,
          Field{"m", "the clock starts when the robot has moved this far", 0.0, 1.0});
    visit("control_hz", control_hz, Field{"Hz", "how often the base takes a command", 1.0, 200.0});
    visit("accel_mps2", accel_mps2, Field{"m/s^2", "most that the base changes its speed", 0.1, 100.0});
    visit("max_w_radps", max_w_radps, Field{"rad/s", "fastest turn of the base", 0.1, 20.0});
    visit("turn_accel_radps2", turn_accel_radps2,
          Field{"rad/s^2", "most that the base changes its turn rate", 0.1, 200.0});
  }
};

/// Time by which a run is scored: success * OT / clip(time, k OT, 8 OT), OT the reference path at 2 m/s.
double barnScore(bool success, double time_s, double path_length_m, double k);

/// Drives a run by the rules at a speed cap. The record's time is the clock's; the outcome is "reached",
/// "aborted", "time_out" or "contact".
DriveRecord driveBarn(sim::Simulator& simulator, Driver& driver, const Eigen::Vector2d& p_world_goal,
                      double max_v_mps, const BarnRules& rules);

}  // namespace frugal_nav::eval
