#pragma once

#include <string>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/control/base_control.hpp>

namespace frugal_nav {

/// Parameters of the node base_controller: config/base_controller.yaml. This header needs no ROS.
struct BaseControllerNodeParams {
  double rate_hz = 20.0;
  std::string odom_frame = "odom";
  std::string base_frame = "base_link";
  BaseControlParams control;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("rate_hz", rate_hz,
          atStart(Field{"Hz", "control cycles while no input starts one: time-outs are noticed at this rate",
                        1.0, 200.0}));
    visit("odom_frame", odom_frame, atStart(Field{"", "frame of path, targets and odometry"}));
    visit("base_frame", base_frame, atStart(Field{"", "frame of the robot, of scans and commands"}));
    control.fields(visit);
  }
  std::string check() const {
    return control.guard.hold_s * rate_hz < 1.0 - 1e-9 ? "guard/hold_s must be a cycle, 1 / rate_hz, or more"
                                                       : "";
  }
};

}  // namespace frugal_nav
