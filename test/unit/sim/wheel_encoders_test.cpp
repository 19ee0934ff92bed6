#include <cmath>

#include <gtest/gtest.h>

#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/sim/wheel_encoders.hpp>

namespace frugal_nav::sim {
namespace {

TEST(WheelEncoders, CountWholeTicksDownToTheFloor) {
  WheelEncoderParams params;
  params.ticks_per_revolution = 100;
  const WheelEncoders encoders(params);
  const double tick_rad = 2.0 * M_PI / 100.0;
  const WheelTicks ticks = encoders.sample(stampFromSeconds(2.0), 3.99 * tick_rad, -0.01 * tick_rad);
  EXPECT_EQ(ticks.stamp, stampFromSeconds(2.0));
  EXPECT_EQ(ticks.left, 3);
  EXPECT_EQ(ticks.right, -1);
}

TEST(WheelEncoders, RefusesNoTicks) {
  WheelEncoderParams params;
  params.ticks_per_revolution = 0;
  EXPECT_THROW(WheelEncoders{params}, ConfigError);
}

TEST(WheelEncoders, ShippedProfileHoldsTheDefaults) {
  const auto profile =
      loadParamFile<WheelEncoderParams>(std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/sensors/encoders.yaml");
  EXPECT_EQ(toYaml(profile), toYaml(WheelEncoderParams{}));
}

}  // namespace
}  // namespace frugal_nav::sim
