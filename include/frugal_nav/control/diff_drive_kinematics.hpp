#pragma once

#include <frugal_nav/common/geometry.hpp>

namespace frugal_nav {

/// Speeds of the two wheels' rims over the floor.
struct WheelSpeeds {
  double left_mps = 0.0;
  double right_mps = 0.0;
};

/// Wheel speeds that make a base move: v -+ w b / 2.
inline WheelSpeeds wheelSpeeds(const Twist2& twist, double separation_m) {
  const double half = 0.5 * separation_m * twist.w_radps;
  return {twist.v_mps - half, twist.v_mps + half};
}

/// Motion that wheel speeds make: v = (r + l) / 2, w = (r - l) / b.
inline Twist2 baseTwist(const WheelSpeeds& wheels, double separation_m) {
  return {0.5 * (wheels.right_mps + wheels.left_mps), (wheels.right_mps - wheels.left_mps) / separation_m};
}

}  // namespace frugal_nav
