#pragma once

#include <optional>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// Gains and bounds of one PID controller.
struct PidParams {
  double kp = 1.0;
  double ki = 0.0;
  double kd = 0.0;
  double max_integral = 0.5;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("kp", kp, Field{"", "output per error", 0.0, 1000.0});
    visit("ki", ki, Field{"1/s", "output per error and second; 0: none", 0.0, 1000.0});
    visit("kd", kd, Field{"s", "output per rate of the measurement; 0: none", 0.0, 1000.0});
    visit("max_integral", max_integral, Field{"", "most the integral part may contribute", 0.0, 1000.0});
  }
};

/// A PID controller: derivative on the measurement (no kick when the set point jumps), output clamped, and an
/// integral that stands still while the output is at its bound and the error would push it further.
class Pid {
 public:
  /// Throws ConfigError on parameters out of range or a bound that is not positive.
  Pid(const PidParams& params, double max_output);

  /// The output for a measurement taken `elapsed_s` after the one before. An elapsed time that is not
  /// positive gives the last output again.
  double update(double setpoint, double measurement, double elapsed_s);
  /// Forgets integral and past.
  void reset();

 private:
  PidParams params_;
  double max_output_;
  double integral_ = 0.0;
  double output_ = 0.0;
  std::optional<double> last_measurement_;
};

}  // namespace frugal_nav
