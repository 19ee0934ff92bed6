#include "flat_world.hpp"

#include <gtest/gtest.h>

#include <frugal_nav/planning/dynamic_window.hpp>

namespace frugal_nav {
namespace {

using planning_test::FlatWorld;
using planning_test::kBody;

class DynamicWindowTest : public testing::Test {
 protected:
  MotionCommand plan(const FlatWorld& world, const Twist2& present, const Eigen::Vector2d& target) {
    const LaserScan scan = world.scan({}, 1.0);
    window.reset();
    window.update(scan, {}, {0.0, 0.0});
    const std::vector<Eigen::Vector2d> obstacles = obstaclePoints(scan, {});
    Odometry odometry;
    odometry.twist = present;
    return method.plan({scan, {}, obstacles, odometry, target, target, &window});
  }

  DynamicWindowParams params;
  SpeedParams speed;
  DynamicWindow method{params, speed, kBody};
  ActiveWindow window{RollingGridParams{}};
};

TEST_F(DynamicWindowTest, AsksOnlyForWhatCanBeReachedByTheNextCommand) {
  const MotionCommand command = plan(FlatWorld().box(-5, -5, 5, 5), {0.10, 0.2}, {4.0, 0.0});
  EXPECT_EQ(command.holds, MotionCommand::Holds::kVelocity);
  EXPECT_NEAR(command.velocity.v_mps, 0.10 + params.accel_mps2 * params.period_s, 1e-9)
      << "free ahead: faster";
  EXPECT_LE(std::abs(command.velocity.w_radps - 0.2), params.turn_accel_radps2 * params.period_s + 1e-9);
}

TEST_F(DynamicWindowTest, TurnsTowardTheTarget) {
  EXPECT_GT(plan(FlatWorld().box(-5, -5, 5, 5), {}, {0.0, 2.0}).velocity.w_radps, 0.2);
  EXPECT_LT(plan(FlatWorld().box(-5, -5, 5, 5), {}, {0.0, -2.0}).velocity.w_radps, -0.2);
}

TEST_F(DynamicWindowTest, SpeedsThatItCannotStopFromAreNotAdmissible) {
  // 0.30 m to a wall that reaches across: 0.16 m of body and 0.03 m of margin leave 0.11 m to stop in.
  const FlatWorld wall = FlatWorld().wall(0.30, -2.0, 0.30, 2.0);
  const MotionCommand command = plan(wall, {0.20, 0.0}, {4.0, 0.0});
  const double stoppable_mps = SpeedChoice(speed, kBody).stoppable_mps(0.11);
  EXPECT_LE(command.velocity.v_mps, stoppable_mps + 1e-9);
  EXPECT_LT(command.velocity.v_mps, 0.20);
}

TEST_F(DynamicWindowTest, PassesBesideABoxAhead) {
  const MotionCommand command =
      plan(FlatWorld().box(-5, -5, 5, 5).box(0.6, -0.25, 0.9, 0.10), {0.25, 0.0}, {3.0, 0.0});
  EXPECT_EQ(command.status, MotionCommand::Status::kDriving);
  EXPECT_GT(command.velocity.w_radps, 0.0) << "the shorter way is to the left";
}

}  // namespace
}  // namespace frugal_nav
