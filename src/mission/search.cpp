#include <frugal_nav/mission/search.hpp>

namespace frugal_nav {

void Search::start(const Odometry& odometry) {
  state_ = State::kTurning;
  start_ = odometry.stamp;
  last_yaw_rad_ = odometry.odom_from_base.yaw_rad;
  turned_rad_ = 0.0;
}

Twist2 Search::update(const Odometry& odometry) {
  turned_rad_ += angleBetween(last_yaw_rad_, odometry.odom_from_base.yaw_rad);
  last_yaw_rad_ = odometry.odom_from_base.yaw_rad;
  if (turned_rad_ >= params_.turn_rad) {
    state_ = State::kDone;
  } else if (toSeconds(odometry.stamp - start_) >= params_.timeout_s) {
    state_ = State::kHeldUp;
  }
  return state_ == State::kTurning ? Twist2{0.0, params_.turn_radps} : Twist2{};
}

}  // namespace frugal_nav
