#pragma once

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/control/base_control.hpp>
#include <frugal_nav/control/velocity_limiter.hpp>
#include <frugal_nav/control/waypoint_controller.hpp>
#include <frugal_nav/odometry/wheel_odometry.hpp>
#include <frugal_nav/robot/robot_model.hpp>
#include <frugal_nav/sim/sensor_data.hpp>

namespace frugal_nav::eval {

/// Drives straight at a goal with the waypoint controller, nothing looked at: what every suite's methods have
/// to beat.
class StraightDrive {
 public:
  /// Counts as there within `aim_m`.
  StraightDrive(const WheelOdometryParams& odometry, const BaseControlParams& base, double aim_m,
                const RobotModel& robot, const Pose2& odom_from_goal);

  Twist2 addTicks(const sim::WheelTicks& ticks);
  const Pose2& odometry() const { return odom_from_base_; }
  bool reached() const { return reached_; }
  const Twist2& command() const { return command_; }

 private:
  Pose2 goal_;
  double aim_m_;
  WheelOdometry wheels_;
  WaypointController controller_;
  VelocityLimiter limiter_;
  Pose2 odom_from_base_;
  Twist2 command_;
  Stamp last_{};
  bool reached_ = false;
};

}  // namespace frugal_nav::eval
