#include <cmath>

#include <frugal_nav/mission/recovery.hpp>

namespace frugal_nav {

void Recovery::start(const Odometry& odometry, double clear_bearing_rad, bool backs_off) {
  backs_off_ = backs_off;
  goal_yaw_rad_ = wrapAngle(odometry.odom_from_base.yaw_rad + clear_bearing_rad);
  enter(Step::kTurn, odometry);
}

Twist2 Recovery::update(const Odometry& odometry) {
  switch (step_) {
    case Step::kTurn:
      return turn(odometry);
    case Step::kBackOff:
      return backOff(odometry);
    case Step::kDone:
      break;
  }
  return {};
}

Twist2 Recovery::turn(const Odometry& odometry) {
  const double error_rad = angleBetween(odometry.odom_from_base.yaw_rad, goal_yaw_rad_);
  if (std::abs(error_rad) <= params_.turn_tolerance_rad ||
      toSeconds(odometry.stamp - step_start_) >= params_.turn_timeout_s) {
    enter(backs_off_ ? Step::kBackOff : Step::kDone, odometry);
    return {};
  }
  return {0.0, std::copysign(params_.turn_radps, error_rad)};
}

Twist2 Recovery::backOff(const Odometry& odometry) {
  if (distance(step_pose_, odometry.odom_from_base) >= params_.back_off_m ||
      toSeconds(odometry.stamp - step_start_) >= params_.back_off_timeout_s) {
    enter(Step::kDone, odometry);
    return {};
  }
  return {-params_.back_off_mps, 0.0};
}

void Recovery::enter(Step step, const Odometry& odometry) {
  step_ = step;
  step_start_ = odometry.stamp;
  step_pose_ = odometry.odom_from_base;
}

}  // namespace frugal_nav
