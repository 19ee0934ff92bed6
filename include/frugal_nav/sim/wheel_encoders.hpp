#pragma once

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/sim/sensor_data.hpp>

namespace frugal_nav::sim {

/// Encoders on both wheels.
struct WheelEncoderParams {
  double rate_hz = 50.0;
  int ticks_per_revolution = 1440;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("rate_hz", rate_hz, Field{"Hz", "readings a second", 1.0, 200.0});
    visit("ticks_per_revolution", ticks_per_revolution,
          Field{"", "counts of one turn of a wheel: 12 pole pairs, quadrature, 30:1 gear", 1, 1000000});
  }
};

/// Encoders that count whole ticks of each wheel's angle, from zero at the start.
class WheelEncoders {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit WheelEncoders(const WheelEncoderParams& params);

  /// The counts at the wheels' angles [rad].
  WheelTicks sample(Stamp stamp, double left_rad, double right_rad) const;

 private:
  WheelEncoderParams params_;
};

}  // namespace frugal_nav::sim
