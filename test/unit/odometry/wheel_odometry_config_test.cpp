#include <set>
#include <string>

#include <gtest/gtest.h>

#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/ros/wheel_odometry_params.hpp>

namespace frugal_nav {
namespace {

const std::string kFile = std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/wheel_odometry.yaml";

// The file documents every parameter and changes none: whoever reads it knows the defaults.
TEST(WheelOdometryNodeParams, TheFileHoldsEveryParameterWithItsDefault) {
  const WheelOdometryNodeParams loaded = loadParamFile<WheelOdometryNodeParams>(kFile);
  EXPECT_EQ(toYaml(loaded), toYaml(WheelOdometryNodeParams{}));
  std::set<std::string> wanted;
  for (const FieldDescription& field : describe(WheelOdometryNodeParams{})) wanted.insert(field.name);
  std::set<std::string> found;
  for (const auto& [key, value] : readParamFile(kFile)) found.insert(key);
  EXPECT_EQ(found, wanted);
}

TEST(WheelOdometryNodeParams, TheSimulatedRobotsFileHoldsItsCalibrationAlone) {
  const std::string file = std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/simulated/wheel_odometry.yaml";
  EXPECT_NO_THROW(loadParamFile<WheelOdometryNodeParams>(file));
  for (const auto& [key, value] : readParamFile(file))
    EXPECT_NE(key.find("_multiplier"), std::string::npos) << key;
}

}  // namespace
}  // namespace frugal_nav
