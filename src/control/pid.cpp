#include <algorithm>
#include <cmath>

#include <frugal_nav/control/pid.hpp>

namespace frugal_nav {

Pid::Pid(const PidParams& params, double max_output) : params_(params), max_output_(max_output) {
  validate(params, "pid");
  if (!(max_output > 0.0)) throw ConfigError("pid: the bound of the output must be positive");
}

double Pid::update(double setpoint, double measurement, double elapsed_s) {
  if (!(elapsed_s > 0.0)) return output_;
  const double error = setpoint - measurement;
  const double rate = last_measurement_ ? (measurement - *last_measurement_) / elapsed_s : 0.0;
  last_measurement_ = measurement;

  const double without_integral = params_.kp * error - params_.kd * rate;
  const double integral =
      std::clamp(integral_ + params_.ki * error * elapsed_s, -params_.max_integral, params_.max_integral);
  const double wanted = without_integral + integral;
  const bool winds_up = std::abs(wanted) > max_output_ && wanted * error > 0.0;
  if (!winds_up) integral_ = integral;
  output_ = std::clamp(without_integral + integral_, -max_output_, max_output_);
  return output_;
}

void Pid::reset() {
  integral_ = 0.0;
  output_ = 0.0;
  last_measurement_.reset();
}

}  // namespace frugal_nav
