#pragma once

#include <cmath>
#include <string>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/odometry/wheel_odometry.hpp>

namespace frugal_nav {

/// Parameters of the node wheel_odometry: config/wheel_odometry.yaml. This header needs no ROS.
struct WheelOdometryNodeParams {
  std::string source = "ticks";
  std::string odom_frame = "odom";
  std::string base_frame = "base_link";
  bool publish_tf = true;
  WheelOdometryParams odometry;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("source", source,
          atStart(
              Field{"",
                    "what the wheels report: counts on wheel_ticks, or angles of the URDF's wheel joints on "
                    "joint_states",
                    -HUGE_VAL, HUGE_VAL, "ticks|joint_states"}));
    visit("odom_frame", odom_frame, atStart(Field{"", "frame the odometry is in"}));
    visit("base_frame", base_frame, atStart(Field{"", "frame of the robot"}));
    visit("publish_tf", publish_tf,
          atStart(Field{
              "", "broadcast odom_frame -> base_frame; false when another filter owns that transform"}));
    odometry.fields(visit);
  }
  std::string check() const { return odometry.check(); }
};

}  // namespace frugal_nav
