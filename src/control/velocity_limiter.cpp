#include <algorithm>
#include <cmath>

#include <frugal_nav/control/diff_drive_kinematics.hpp>
#include <frugal_nav/control/velocity_limiter.hpp>

namespace frugal_nav {
namespace {

Twist2 scaled(const Twist2& twist, double factor) { return {factor * twist.v_mps, factor * twist.w_radps}; }

/// The factor that brings a magnitude within its bound.
double factorFor(double magnitude, double bound) { return magnitude > bound ? bound / magnitude : 1.0; }

}  // namespace

VelocityLimiter::VelocityLimiter(const VelocityLimits& limits, double separation_m)
    : limits_(limits), separation_m_(separation_m) {
  validate(limits, "velocity limits");
  if (!(separation_m > 0.0)) throw ConfigError("velocity limits: the wheel separation must be positive");
}

Twist2 VelocityLimiter::limitSpeed(const Twist2& wanted) const {
  const double max_v = wanted.v_mps < 0.0 ? limits_.max_reverse_mps : limits_.max_v_mps;
  const WheelSpeeds wheels = wheelSpeeds(wanted, separation_m_);
  const double fastest = std::max(std::abs(wheels.left_mps), std::abs(wheels.right_mps));
  return scaled(wanted, std::min({factorFor(std::abs(wanted.v_mps), max_v),
                                  factorFor(std::abs(wanted.w_radps), limits_.max_w_radps),
                                  factorFor(fastest, limits_.max_wheel_mps)}));
}

Twist2 VelocityLimiter::limitForObstacles(const Twist2& wanted, double free_distance_m) const {
  const double stoppable = std::sqrt(2.0 * limits_.decel_mps2 * std::max(free_distance_m, 0.0));
  return scaled(wanted, factorFor(std::abs(wanted.v_mps), std::max(stoppable, limits_.creep_mps)));
}

Twist2 VelocityLimiter::limitAcceleration(const Twist2& wanted, const Twist2& from, double elapsed_s) const {
  const double dt = std::max(elapsed_s, 0.0);
  // Away from zero the robot speeds up, toward it it slows down; a change of direction slows down first.
  const bool slows = std::abs(wanted.v_mps) < std::abs(from.v_mps) || wanted.v_mps * from.v_mps < 0.0;
  const double dv = (slows ? limits_.decel_mps2 : limits_.accel_mps2) * dt;
  const double dw = limits_.turn_accel_radps2 * dt;
  return {std::clamp(wanted.v_mps, from.v_mps - dv, from.v_mps + dv),
          std::clamp(wanted.w_radps, from.w_radps - dw, from.w_radps + dw)};
}

}  // namespace frugal_nav
