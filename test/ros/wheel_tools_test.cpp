// The program calibrate_wheels as people run it.

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <support/ros_test.hpp>
#include <support/temp_folder.hpp>

#include <frugal_nav/odometry/wheel_calibration.hpp>

namespace frugal_nav {
namespace {

using test::ProgramResult;
using test::runProgram;
using testing::HasSubstr;

const std::string kSource = FRUGAL_NAV_SOURCE_DIR;
const std::string kRobot = "--urdf " + kSource + "/urdf/frugal_bot.urdf ";
const std::string kConfig = "--config " + kSource + "/config/wheel_odometry.yaml ";

double valueOf(const std::string& output, const std::string& key) {
  const std::size_t at = output.find(key + ": ");
  return at == std::string::npos ? 0.0 : std::stod(output.substr(at + key.size() + 2));
}

TEST(CalibrateWheels, PrintsTheMultipliersOfTheSquares) {
  const ProgramResult result = runProgram(
      "calibrate_wheels", kRobot + kConfig + "--side 4 --cw 0.10,-0.21 --cw 0.12,-0.19 --ccw 0.05,0.30");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const WheelCalibration expected = calibrateWheels({{{0.11, -0.20}}, {{0.05, 0.30}}}, 4.0, 0.21);
  EXPECT_NEAR(valueOf(result.output, "left_radius_multiplier"), expected.left_radius_multiplier, 1e-6);
  EXPECT_NEAR(valueOf(result.output, "right_radius_multiplier"), expected.right_radius_multiplier, 1e-6);
  EXPECT_NEAR(valueOf(result.output, "separation_multiplier"), expected.separation_multiplier, 1e-6);
}

TEST(CalibrateWheels, MultipliesWhatItWasDrivenWithAndTheStraightRun) {
  const test::TempFolder folder;
  const std::string used = folder.write(
      "used.yaml", "left_radius_multiplier: 1.1\nright_radius_multiplier: 0.9\nseparation_multiplier: 1.2\n");
  const ProgramResult result = runProgram(
      "calibrate_wheels", kRobot + "--config " + used + " --side 4 --cw 0,0 --ccw 0,0 --straight 4.04,4.00");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NEAR(valueOf(result.output, "left_radius_multiplier"), 1.1 * 1.01, 1e-6);
  EXPECT_NEAR(valueOf(result.output, "right_radius_multiplier"), 0.9 * 1.01, 1e-6);
  EXPECT_NEAR(valueOf(result.output, "separation_multiplier"), 1.2 * 1.01, 1e-6)
      << "turns stay what they were";
}

TEST(CalibrateWheels, RefusesWhatItCannotUse) {
  for (const std::string& arguments :
       {std::string(), kRobot + kConfig, kRobot + kConfig + "--side", kRobot + kConfig + "--side 4 --cw 0.1",
        kRobot + kConfig + "--side 4 --straight 0,4", kRobot + kConfig + "--side nan"}) {
    const ProgramResult result = runProgram("calibrate_wheels", arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.output, HasSubstr("usage")) << arguments;
  }
  const ProgramResult one_way = runProgram("calibrate_wheels", kRobot + kConfig + "--side 4 --cw 0.1,0.1");
  EXPECT_EQ(one_way.exit_code, 1);
  EXPECT_THAT(one_way.output, HasSubstr("no counter-clockwise square"));
  EXPECT_EQ(runProgram("calibrate_wheels", "--help").exit_code, 0);
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
