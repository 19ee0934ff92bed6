#include <cmath>

#include <gtest/gtest.h>

#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/sim/drive_body.hpp>

namespace frugal_nav::sim {
namespace {

constexpr double kStep_s = 0.005;
const DriveGeometry kDrive{"left", "right", 0.21, 0.033};

DriveBodyParams withoutSlip() {
  DriveBodyParams params;
  params.slip_scale = 0.0;
  return params;
}

Pose2 drive(DriveBody& body, const Twist2& command, double duration_s) {
  Pose2 start_from_base;
  body.command(command);
  for (int i = 0; i < std::lround(duration_s / kStep_s); ++i)
    start_from_base = start_from_base * body.step(kStep_s);
  return start_from_base;
}

TEST(DriveBody, WithoutSlipTheWheelsTellTheMotionExactly) {
  DriveBodyParams params = withoutSlip();
  params.max_wheel_acceleration_mps2 = 100.0;
  DriveBody body(params, kDrive, 1);
  const Pose2 pose = drive(body, {0.3, 0.5}, 4.0);
  const double left_m = body.leftAngle_rad() * kDrive.radius_m;
  const double right_m = body.rightAngle_rad() * kDrive.radius_m;
  // Sums of 800 steps in double: rounding only.
  EXPECT_NEAR(wrapAngle((right_m - left_m) / kDrive.separation_m), pose.yaw_rad, 1e-9);
  // Both wheels have the same lag, and neither torque nor speed limit acts: the path is one arc of radius
  // v/w.
  const double angle = (right_m - left_m) / kDrive.separation_m;
  const double radius_m = 0.3 / 0.5;
  EXPECT_NEAR(pose.x_m, radius_m * std::sin(angle), 1e-9);
  EXPECT_NEAR(pose.y_m, radius_m * (1.0 - std::cos(angle)), 1e-9);
}

TEST(DriveBody, MotorFollowsItsTimeConstant) {
  DriveBodyParams params = withoutSlip();
  params.max_wheel_acceleration_mps2 = 100.0;
  params.motor_time_constant_s = 0.1;
  DriveBody body(params, kDrive, 1);
  drive(body, {0.4, 0.0}, 0.1);
  EXPECT_NEAR(body.twist().v_mps, 0.4 * (1.0 - std::exp(-1.0)), 1e-9);
}

TEST(DriveBody, TorqueLimitsTheAcceleration) {
  DriveBodyParams params = withoutSlip();
  params.max_wheel_acceleration_mps2 = 0.5;
  DriveBody body(params, kDrive, 1);
  drive(body, {1.0, 0.0}, 0.2);
  EXPECT_NEAR(body.twist().v_mps, 0.1, 1e-9);
}

TEST(DriveBody, AtFullSpeedAnArcKeepsItsRadius) {
  DriveBody body(withoutSlip(), kDrive, 1);
  drive(body, {2.0, 4.0}, 3.0);
  EXPECT_NEAR(body.twist().v_mps + body.twist().w_radps * kDrive.separation_m / 2.0, 1.0, 1e-6);
  EXPECT_NEAR(body.twist().v_mps / body.twist().w_radps, 0.5, 1e-6);
}

TEST(DriveBody, SlipGrowsWithSpeedAndTurnRate) {
  const auto lostShare = [](const Twist2& command) {
    DriveBodyParams params;
    params.slip_noise = 0.0;
    DriveBody body(params, kDrive, 1);
    drive(body, command, 1.0);
    return 1.0 - std::abs(body.twist().v_mps) / std::abs(command.v_mps);
  };
  EXPECT_NEAR(lostShare({0.2, 0.0}), 0.02 * 0.2, 1e-5);
  EXPECT_NEAR(lostShare({0.4, 0.0}), 0.02 * 0.4, 1e-5);
  EXPECT_GT(lostShare({0.2, 1.0}), lostShare({0.2, 0.0}) + 0.01);
}

TEST(DriveBody, WheelsNeverTurnLessThanTheBodyMoves) {
  DriveBodyParams params;
  params.slip_noise = 2.0;
  params.slip_scale = 5.0;
  DriveBody body(params, kDrive, 3);
  const Pose2 pose = drive(body, {0.5, 0.0}, 5.0);
  const double turned_m = kDrive.radius_m * (body.leftAngle_rad() + body.rightAngle_rad()) / 2.0;
  EXPECT_LT(pose.position().norm(), turned_m);
}

TEST(DriveBody, TrueRadiusAndSeparationDifferFromWhatTheDriverBelieves) {
  DriveBodyParams params = withoutSlip();
  params.left_radius_multiplier = 1.02;
  params.right_radius_multiplier = 1.02;
  params.separation_multiplier = 1.05;
  DriveBody body(params, kDrive, 1);
  drive(body, {0.3, 0.6}, 3.0);
  EXPECT_NEAR(body.twist().v_mps, 0.3 * 1.02, 1e-9);
  EXPECT_NEAR(body.twist().w_radps, 0.6 * 1.02 / 1.05, 1e-9);
}

TEST(DriveBody, ABlockedStepLeavesOnlyItsFreePart) {
  DriveBody body(withoutSlip(), kDrive, 1);
  drive(body, {0.3, 0.0}, 1.0);
  const double before_rad = body.leftAngle_rad();
  body.step(kStep_s);
  const double turn_rad = body.leftAngle_rad() - before_rad;
  body.block(0.25);
  EXPECT_NEAR(body.leftAngle_rad(), before_rad + 0.25 * turn_rad, 1e-12);
  EXPECT_TRUE(body.twist().isZero());
}

TEST(DriveBody, SameSeedSameSlip) {
  DriveBody first(DriveBodyParams{}, kDrive, 7);
  DriveBody second(DriveBodyParams{}, kDrive, 7);
  DriveBody other(DriveBodyParams{}, kDrive, 8);
  const Pose2 a = drive(first, {0.4, 0.3}, 5.0);
  const Pose2 b = drive(second, {0.4, 0.3}, 5.0);
  const Pose2 c = drive(other, {0.4, 0.3}, 5.0);
  EXPECT_EQ(a.x_m, b.x_m);
  EXPECT_EQ(a.yaw_rad, b.yaw_rad);
  EXPECT_NE(a.x_m, c.x_m);
}

TEST(DriveBody, RefusesParametersOutOfRange) {
  DriveBodyParams params;
  params.motor_time_constant_s = -1.0;
  EXPECT_THROW(DriveBody(params, kDrive, 1), ConfigError);
}

TEST(DriveBody, ShippedProfileHoldsTheDefaults) {
  const auto profile =
      loadParamFile<DriveBodyParams>(std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/body.yaml");
  EXPECT_EQ(toYaml(profile), toYaml(DriveBodyParams{}));
}

}  // namespace
}  // namespace frugal_nav::sim
