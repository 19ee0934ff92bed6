#include <gtest/gtest.h>

#include <frugal_nav/eval/lidar_stack.hpp>

// What lidar_avoidance may ask of the base must be what base_controller grants: two files, which roslaunch
// loads into two nodes.
namespace frugal_nav::eval {
namespace {

const std::string kConfig = std::string(FRUGAL_NAV_SOURCE_DIR) + "/config";

void expectAgreement(const LidarStackParams& params) {
  const VelocityLimits& limits = params.base.limits;
  const LidarAvoidanceParams& avoidance = params.avoidance;
  EXPECT_EQ(avoidance.speed.max_v_mps, limits.max_v_mps);
  EXPECT_LE(avoidance.speed.max_w_radps, limits.max_w_radps);
  EXPECT_LE(avoidance.speed.brake_mps2, limits.decel_mps2);
  EXPECT_EQ(avoidance.dwa.accel_mps2, limits.accel_mps2);
  EXPECT_EQ(avoidance.dwa.turn_accel_radps2, limits.turn_accel_radps2);
  EXPECT_LE(avoidance.right_of_way.cruise_mps, limits.max_v_mps);
  EXPECT_GE(avoidance.right_of_way.cruise_mps, 0.8 * limits.max_v_mps);
  EXPECT_EQ(avoidance.right_of_way.accel_mps2, limits.accel_mps2);
}

TEST(LidarStackParams, AvoidanceKnowsTheLimitsOfTheBase) {
  expectAgreement(loadLidarStack(kConfig));
  expectAgreement(loadLidarStack(kConfig, "barn"));
}

}  // namespace
}  // namespace frugal_nav::eval
