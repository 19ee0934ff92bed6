#include <set>
#include <string>

#include <gtest/gtest.h>

#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/ros/wheel_odometry_params.hpp>

namespace frugal_nav {
namespace {

const std::string kFile = std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/wheel_odometry.yaml";

// The file documents every parameter and changes none but the calibration of the robot it comes with.
TEST(WheelOdometryNodeParams, TheFileHoldsEveryParameterWithItsDefault) {
  WheelOdometryNodeParams loaded = loadParamFile<WheelOdometryNodeParams>(kFile);
  const WheelOdometryParams defaults;
  loaded.odometry.left_radius_multiplier = defaults.left_radius_multiplier;
  loaded.odometry.right_radius_multiplier = defaults.right_radius_multiplier;
  loaded.odometry.separation_multiplier = defaults.separation_multiplier;
  EXPECT_EQ(toYaml(loaded), toYaml(WheelOdometryNodeParams{}));
  std::set<std::string> wanted;
  for (const FieldDescription& field : describe(WheelOdometryNodeParams{})) wanted.insert(field.name);
  std::set<std::string> found;
  for (const auto& [key, value] : readParamFile(kFile)) found.insert(key);
  EXPECT_EQ(found, wanted);
}

}  // namespace
}  // namespace frugal_nav
