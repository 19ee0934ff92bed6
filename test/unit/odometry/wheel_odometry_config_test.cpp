#include <string>

#include <gtest/gtest.h>
#include <support/param_files.hpp>

#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/ros/wheel_odometry_params.hpp>

namespace frugal_nav {
namespace {

TEST(WheelOdometryNodeParams, TheFileHoldsEveryParameterWithItsDefault) {
  test::expectDefaults<WheelOdometryNodeParams>("wheel_odometry.yaml");
}

TEST(WheelOdometryNodeParams, TheSimulatedRobotsFileHoldsItsCalibrationAlone) {
  const std::string file = std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/simulated/wheel_odometry.yaml";
  EXPECT_NO_THROW(loadParamFile<WheelOdometryNodeParams>(file));
  for (const auto& [key, value] : readParamFile(file))
    EXPECT_NE(key.find("_multiplier"), std::string::npos) << key;
}

}  // namespace
}  // namespace frugal_nav
