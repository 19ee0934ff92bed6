#pragma once

#include <string>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// What the base may be asked for.
struct VelocityLimits {
  double max_v_mps = 0.35;
  double max_reverse_mps = 0.15;
  double max_w_radps = 1.0;
  double max_wheel_mps = 0.6;
  double accel_mps2 = 0.6;
  double decel_mps2 = 1.0;
  double turn_accel_radps2 = 4.0;
  double creep_mps = 0.06;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("max_v_mps", max_v_mps, Field{"m/s", "fastest forward: a person steps aside in time", 0.01, 5.0});
    visit("max_reverse_mps", max_reverse_mps, Field{"m/s", "fastest backward; 0: never", 0.0, 5.0});
    visit("max_w_radps", max_w_radps,
          Field{"rad/s", "fastest turn: the tyres slip with the turn rate, which odometry cannot see", 0.05,
                10.0});
    visit("max_wheel_mps", max_wheel_mps,
          Field{"m/s", "fastest rim of a wheel: well inside what the motors reach", 0.01, 10.0});
    visit("accel_mps2", accel_mps2, Field{"m/s^2", "speeding up: above it the small tyres slip", 0.05, 20.0});
    visit("decel_mps2", decel_mps2,
          Field{"m/s^2", "slowing down; the stopping distances rest on it", 0.05, 20.0});
    visit("turn_accel_radps2", turn_accel_radps2, Field{"rad/s^2", "change of the turn rate", 0.1, 100.0});
    visit(
        "creep_mps", creep_mps,
        Field{"m/s", "slowest that nearby obstacles make it; the collision stop alone goes below", 0.0, 1.0});
  }
  std::string check() const { return creep_mps <= max_v_mps ? "" : "creep_mps must not exceed max_v_mps"; }
};

/// Keeps commands within the limits, without changing the curve they drive where speed is the matter.
class VelocityLimiter {
 public:
  /// Throws ConfigError on limits out of range or a separation that is not positive.
  VelocityLimiter(const VelocityLimits& limits, double separation_m);

  /// Scales v and w together until speeds and wheel speeds are within their limits.
  Twist2 limitSpeed(const Twist2& wanted) const;
  /// Scales v and w together so that the robot can stop within the free distance ahead:
  /// v <= sqrt(2 a d), but not below creep_mps.
  Twist2 limitForObstacles(const Twist2& wanted, double free_distance_m) const;
  /// Bounds the change from a velocity within an elapsed time.
  Twist2 limitAcceleration(const Twist2& wanted, const Twist2& from, double elapsed_s) const;

  const VelocityLimits& limits() const { return limits_; }

 private:
  VelocityLimits limits_;
  double separation_m_;
};

}  // namespace frugal_nav
