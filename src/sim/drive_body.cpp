#include <algorithm>
#include <cmath>

#include <frugal_nav/sim/drive_body.hpp>

namespace frugal_nav::sim {

DriveBody::DriveBody(const DriveBodyParams& params, const DriveGeometry& geometry, std::uint64_t seed)
    : params_(params),
      geometry_(geometry),
      left_{geometry.radius_m * params.left_radius_multiplier, 0.0, 0.0, 0.0, 0.0, Random(seed, "slip_left")},
      right_{geometry.radius_m * params.right_radius_multiplier,
             0.0,
             0.0,
             0.0,
             0.0,
             Random(seed, "slip_right")} {
  validate(params, "body");
}

Pose2 DriveBody::step(double duration_s) {
  double left_mps = command_.v_mps - command_.w_radps * geometry_.separation_m / 2.0;
  double right_mps = command_.v_mps + command_.w_radps * geometry_.separation_m / 2.0;
  const double fastest_mps = std::max(std::abs(left_mps), std::abs(right_mps));
  const double scale =
      fastest_mps > params_.max_wheel_speed_mps ? params_.max_wheel_speed_mps / fastest_mps : 1.0;
  drive(left_, scale * left_mps / geometry_.radius_m, duration_s);
  drive(right_, scale * right_mps / geometry_.radius_m, duration_s);

  const double separation_m = geometry_.separation_m * params_.separation_multiplier;
  const double turn_radps =
      (right_.speed_radps * right_.true_radius_m - left_.speed_radps * left_.true_radius_m) / separation_m;
  const double left_ground_mps = groundSpeed_mps(left_, turn_radps, duration_s);
  const double right_ground_mps = groundSpeed_mps(right_, turn_radps, duration_s);
  twist_ = {(left_ground_mps + right_ground_mps) / 2.0, (right_ground_mps - left_ground_mps) / separation_m};
  return arcMotion(twist_, duration_s);
}

void DriveBody::block(double fraction) {
  for (Wheel* wheel : {&left_, &right_}) {
    wheel->angle_rad -= (1.0 - fraction) * wheel->last_turn_rad;
    wheel->last_turn_rad *= fraction;
    wheel->speed_radps = 0.0;
  }
  twist_ = {};
}

void DriveBody::drive(Wheel& wheel, double target_radps, double duration_s) const {
  const double time_constant_s = params_.motor_time_constant_s;
  const double share = time_constant_s > 0.0 ? 1.0 - std::exp(-duration_s / time_constant_s) : 1.0;
  const double limit_radps = params_.max_wheel_acceleration_mps2 / geometry_.radius_m * duration_s;
  wheel.speed_radps += std::clamp(share * (target_radps - wheel.speed_radps), -limit_radps, limit_radps);
  wheel.last_turn_rad = wheel.speed_radps * duration_s;
  wheel.angle_rad += wheel.last_turn_rad;
}

double DriveBody::groundSpeed_mps(Wheel& wheel, double turn_radps, double duration_s) const {
  // The deviation is a stationary Gauss-Markov process: the floor changes slowly under the wheel.
  const double keep = std::exp(-duration_s / params_.slip_noise_time_s);
  wheel.slip_deviation = keep * wheel.slip_deviation + wheel.random.normal(std::sqrt(1.0 - keep * keep));
  const double rolling_mps = wheel.speed_radps * wheel.true_radius_m;
  const double mean_slip =
      params_.slip_per_mps * std::abs(rolling_mps) + params_.slip_per_radps * std::abs(turn_radps);
  // A driven wheel turns more than it moves, never less.
  const double slip = std::clamp(
      params_.slip_scale * mean_slip * (1.0 + params_.slip_noise * wheel.slip_deviation), 0.0, 1.0);
  return rolling_mps * (1.0 - slip);
}

}  // namespace frugal_nav::sim
