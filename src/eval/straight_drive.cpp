#include "straight_drive.hpp"

namespace frugal_nav::eval {

StraightDrive::StraightDrive(const WheelOdometryParams& odometry, const BaseControlParams& base, double aim_m,
                             const RobotModel& robot, const Pose2& odom_from_goal)
    : goal_(odom_from_goal),
      aim_m_(aim_m),
      wheels_(odometry, {robot.drive.radius_m, robot.drive.separation_m}),
      controller_(base.waypoint),
      limiter_(base.limits, robot.drive.separation_m) {}

Twist2 StraightDrive::addTicks(const sim::WheelTicks& ticks) {
  const auto odometry = wheels_.addTicks(ticks.stamp, ticks.left, ticks.right);
  if (!odometry) return command_;
  odom_from_base_ = odometry->odom_from_base;
  reached_ = reached_ || distance(odom_from_base_, goal_) < aim_m_;
  const Twist2 wanted = controller_.command(odom_from_base_, goal_.position());
  const double elapsed_s = last_ == Stamp{} ? 0.0 : toSeconds(ticks.stamp - last_);
  last_ = ticks.stamp;
  command_ = limiter_.limitAcceleration(limiter_.limitSpeed(wanted), command_, elapsed_s);
  return command_;
}

}  // namespace frugal_nav::eval
