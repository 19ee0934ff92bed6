#include <cmath>

#include <frugal_nav/sim/wheel_encoders.hpp>

namespace frugal_nav::sim {

WheelEncoders::WheelEncoders(const WheelEncoderParams& params) : params_(params) {
  validate(params, "encoders");
}

WheelTicks WheelEncoders::sample(Stamp stamp, double left_rad, double right_rad) const {
  const auto count = [this](double angle_rad) {
    return static_cast<std::int64_t>(std::floor(angle_rad / (2.0 * M_PI) * params_.ticks_per_revolution));
  };
  return {stamp, count(left_rad), count(right_rad)};
}

}  // namespace frugal_nav::sim
