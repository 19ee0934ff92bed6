#include <cmath>

#include <gtest/gtest.h>

#include <frugal_nav/control/diff_drive_kinematics.hpp>
#include <frugal_nav/control/path_follower.hpp>
#include <frugal_nav/control/pid.hpp>
#include <frugal_nav/control/velocity_limiter.hpp>
#include <frugal_nav/control/waypoint_controller.hpp>

namespace frugal_nav {
namespace {

TEST(Pid, ProportionalOutputIsClamped) {
  Pid pid({2.0, 0.0, 0.0, 1.0}, 0.5);
  EXPECT_DOUBLE_EQ(pid.update(0.1, 0.0, 0.1), 0.2);
  EXPECT_DOUBLE_EQ(pid.update(10.0, 0.0, 0.1), 0.5);
  EXPECT_DOUBLE_EQ(pid.update(-10.0, 0.0, 0.1), -0.5);
}

TEST(Pid, IntegralRemovesAConstantLoad) {
  Pid pid({2.0, 1.0, 0.0, 10.0}, 10.0);
  double state = 0.0;  // d state/dt = output - 1
  for (int i = 0; i < 2000; ++i) state += (pid.update(1.0, state, 0.01) - 1.0) * 0.01;
  EXPECT_NEAR(state, 1.0, 1e-3);
}

TEST(Pid, DoesNotWindUpAtItsBound) {
  Pid pid({1.0, 1.0, 0.0, 100.0}, 1.0);
  for (int i = 0; i < 1000; ++i) pid.update(10.0, 0.0, 0.1);  // a hundred seconds out of reach
  EXPECT_LT(pid.update(0.0, 0.5, 0.1), 0.6) << "the sign of the error must count at once";
}

TEST(Pid, AJumpOfTheSetPointGivesNoDerivativeKick) {
  Pid pid({0.0, 0.0, 1.0, 1.0}, 100.0);
  pid.update(0.0, 0.0, 0.1);
  EXPECT_DOUBLE_EQ(pid.update(5.0, 0.0, 0.1), 0.0);
  EXPECT_NEAR(pid.update(5.0, 0.2, 0.1), -2.0, 1e-12);
}

TEST(Pid, NoTimeGivesTheLastOutput) {
  Pid pid({1.0, 1.0, 1.0, 1.0}, 10.0);
  const double output = pid.update(1.0, 0.0, 0.1);
  EXPECT_DOUBLE_EQ(pid.update(7.0, 3.0, 0.0), output);
  EXPECT_DOUBLE_EQ(pid.update(7.0, 3.0, -1.0), output);
}

TEST(DiffDriveKinematics, InverseUndoesForward) {
  const Twist2 twist{0.3, -1.1};
  const Twist2 again = baseTwist(wheelSpeeds(twist, 0.21), 0.21);
  EXPECT_NEAR(again.v_mps, twist.v_mps, 1e-15);
  EXPECT_NEAR(again.w_radps, twist.w_radps, 1e-15);
  EXPECT_GT(wheelSpeeds({0.0, 1.0}, 0.21).right_mps, 0.0) << "a left turn drives the right wheel forward";
}

class WaypointFrom : public testing::TestWithParam<double> {};

TEST_P(WaypointFrom, ReachesThePoint) {
  const WaypointController controller({});
  Pose2 pose{0.0, 0.0, GetParam()};
  const Eigen::Vector2d target(1.5, 0.8);
  for (int i = 0; i < 2000; ++i) pose = pose * arcMotion(controller.command(pose, target), 0.01);
  EXPECT_LT((pose.position() - target).norm(), 0.031);  // reached_m
  EXPECT_TRUE(controller.command(pose, target).isZero());
}
INSTANTIATE_TEST_SUITE_P(Headings, WaypointFrom, testing::Values(0.0, 0.5, -1.5, 2.5, 3.14, -3.0));

TEST(WaypointController, TurnsOnTheSpotTowardAPointBehind) {
  const WaypointController controller({});
  const Twist2 twist = controller.command({0.0, 0.0, 0.0}, {-1.0, 0.1});
  EXPECT_EQ(twist.v_mps, 0.0);
  EXPECT_GT(twist.w_radps, 0.0);
}

TEST(WaypointController, BadGainsAreRefused) {
  WaypointParams params;
  params.stop_from_rad = 0.1;
  EXPECT_THROW(WaypointController{params}, ConfigError);
}

Path2 sCurve() {
  Path2 path;
  for (int i = 0; i <= 80; ++i) {
    const double x = 0.05 * i;
    path.push_back({x, 0.4 * std::sin(1.5 * x), 0.0});
  }
  return path;
}

TEST(PathFollower, PlaceOnPathIsLeftPositive) {
  const Path2 path{{0.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, {2.0, 2.0, 0.0}};
  const auto left = placeOnPath(path, {0.5, 0.3});
  ASSERT_TRUE(left);
  EXPECT_NEAR(left->lateral_m, 0.3, 1e-12);
  EXPECT_NEAR(left->remaining_m, 3.5, 1e-12);
  EXPECT_NEAR(left->heading_rad, 0.0, 1e-12);
  const auto right = placeOnPath(path, {2.4, 1.5});
  ASSERT_TRUE(right);
  EXPECT_NEAR(right->lateral_m, -0.4, 1e-12);
  EXPECT_NEAR(right->remaining_m, 0.5, 1e-12);
  EXPECT_NEAR(right->heading_rad, M_PI / 2.0, 1e-12);
  EXPECT_FALSE(placeOnPath({{1.0, 1.0, 0.0}, {1.0, 1.0, 0.0}}, {0.0, 0.0}));
}

class PathFollowerFrom : public testing::TestWithParam<Pose2> {};

TEST_P(PathFollowerFrom, StaysOnTheCurveAndStopsAtItsEnd) {
  const Path2 path = sCurve();
  PathFollower follower({});
  Pose2 pose = GetParam();
  double worst_m = 0.0;
  Stamp now = stampFromSeconds(1.0);
  for (int i = 0; i < 3000; ++i) {
    pose = pose * arcMotion(follower.command(path, pose, now), 0.01);
    now += fromSeconds(0.01);
    if (pose.x_m > 1.0) worst_m = std::max(worst_m, std::abs(placeOnPath(path, pose.position())->lateral_m));
  }
  // The look-ahead of 0.25 m cuts a curve of curvature 0.9 / m by 0.25^2 * 0.9 = 6 cm at most.
  EXPECT_LT(worst_m, 0.06);
  EXPECT_LT((pose.position() - path.back().position()).norm(), 0.06 + 0.03);
  EXPECT_TRUE(follower.command(path, pose, now).isZero());
}
INSTANTIATE_TEST_SUITE_P(Starts, PathFollowerFrom,
                         testing::Values(Pose2{0.0, 0.0, 0.5}, Pose2{0.0, 0.2, 0.0}, Pose2{0.0, -0.2, 1.0},
                                         Pose2{0.0, 0.0, 3.0}));

TEST(PathFollower, AnEmptyPathIsZero) {
  PathFollower follower({});
  EXPECT_TRUE(follower.command({}, {0.0, 0.0, 0.0}, stampFromSeconds(1.0)).isZero());
}

TEST(PathFollower, APathOfOnePoseIsDrivenTo) {
  PathFollower follower({});
  const Twist2 twist = follower.command({{1.0, 0.0, 0.0}}, {0.0, 0.0, 0.0}, stampFromSeconds(1.0));
  EXPECT_GT(twist.v_mps, 0.1);
}

TEST(VelocityLimiter, KeepsTheCurveWhenItSlowsDown) {
  const VelocityLimiter limiter({}, 0.21);
  for (const Twist2 wanted : {Twist2{1.0, 1.0}, Twist2{0.3, 4.0}, Twist2{0.34, 1.45}, Twist2{-1.0, 0.5}}) {
    const Twist2 limited = limiter.limitSpeed(wanted);
    EXPECT_NEAR(limited.w_radps * wanted.v_mps, wanted.w_radps * limited.v_mps, 1e-12);
    EXPECT_LE(limited.v_mps, 0.35 + 1e-12);
    EXPECT_GE(limited.v_mps, -0.15 - 1e-12);
    EXPECT_LE(std::abs(limited.w_radps), 1.5 + 1e-12);
    const WheelSpeeds wheels = wheelSpeeds(limited, 0.21);
    EXPECT_LE(std::max(std::abs(wheels.left_mps), std::abs(wheels.right_mps)), 0.6 + 1e-12);
  }
}

TEST(VelocityLimiter, CanStopWithinTheFreeDistance) {
  VelocityLimits limits;
  const VelocityLimiter limiter(limits, 0.21);
  const Twist2 limited = limiter.limitForObstacles({0.35, 0.7}, 0.02);
  EXPECT_NEAR(limited.v_mps * limited.v_mps / (2.0 * limits.decel_mps2), 0.02, 1e-12);
  EXPECT_NEAR(limited.w_radps / limited.v_mps, 2.0, 1e-12);
  EXPECT_NEAR(limiter.limitForObstacles({0.35, 0.0}, 0.0).v_mps, limits.creep_mps, 1e-12);
  EXPECT_EQ(limiter.limitForObstacles({0.35, 0.0}, 1.0).v_mps, 0.35);
}

TEST(VelocityLimiter, SpeedsUpAndSlowsDownAtTheirOwnRates) {
  const VelocityLimiter limiter({}, 0.21);
  EXPECT_NEAR(limiter.limitAcceleration({0.35, 0.0}, {0.1, 0.0}, 0.1).v_mps, 0.16, 1e-12);
  EXPECT_NEAR(limiter.limitAcceleration({0.0, 0.0}, {0.3, 0.0}, 0.1).v_mps, 0.2, 1e-12);
  EXPECT_NEAR(limiter.limitAcceleration({-0.1, 0.0}, {0.3, 0.0}, 0.1).v_mps, 0.2, 1e-12);
  EXPECT_NEAR(limiter.limitAcceleration({-0.1, 0.0}, {0.0, 0.0}, 0.1).v_mps, -0.06, 1e-12);
  EXPECT_NEAR(limiter.limitAcceleration({0.0, 2.0}, {0.0, 0.0}, 0.1).w_radps, 0.4, 1e-12);
  EXPECT_NEAR(limiter.limitAcceleration({0.3, 0.0}, {0.1, 0.0}, -1.0).v_mps, 0.1, 1e-12);
}

}  // namespace
}  // namespace frugal_nav
