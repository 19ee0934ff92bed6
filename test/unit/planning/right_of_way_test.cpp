#include <gtest/gtest.h>

#include <frugal_nav/planning/path_shape.hpp>
#include <frugal_nav/planning/right_of_way.hpp>

namespace frugal_nav {
namespace {

constexpr double kRobotRadius_m = 0.2;

TrackedObstacle walker(const Eigen::Vector2d& p, const Eigen::Vector2d& velocity) {
  TrackedObstacle walker;
  walker.p_odom = p;
  walker.velocity_mps = velocity;
  walker.radius_m = 0.25;
  walker.moving = true;
  walker.covariance.setZero();
  return walker;
}

/// Along x from the origin.
Path2 straightPath(double length_m) { return resample({{0.0, 0.0}, {length_m, 0.0}}, 0.1, 0.0); }

double lengthFor(const TrackedObstacle& obstacle, double length_m = 4.0) {
  return lengthToYield(straightPath(length_m), {obstacle}, kRobotRadius_m, RightOfWayParams{});
}

// The robot drives 0.25 m/s and keeps 0.2 + 0.25 + 0.3 = 0.75 m between the centres.

TEST(RightOfWay, IsTheWholePathWithNobodyAround) {
  EXPECT_DOUBLE_EQ(lengthToYield(straightPath(4.0), {}, kRobotRadius_m, RightOfWayParams{}), 4.0);
}

TEST(RightOfWay, StopsBeforeTheStripOfOneWhoCrosses) {
  // He crosses at x = 1.5 m in four seconds; the robot would be there after six: within late_s and keep.
  const double length = lengthFor(walker({1.5, -2.0}, {0.0, 0.5}));
  EXPECT_NEAR(length, 1.5 - 0.75, 0.05 + 1e-9);
}

TEST(RightOfWay, GoesOnBehindOneWhoHasPassed) {
  EXPECT_DOUBLE_EQ(lengthFor(walker({1.5, 0.9}, {0.0, 0.5})), 4.0);
}

TEST(RightOfWay, PassesBeforeOneWhoComesMuchLater) {
  // At x = 0.5 m, which the robot has left by 0.75 m after five seconds, the walker is in twelve.
  EXPECT_DOUBLE_EQ(lengthFor(walker({0.5, -6.0}, {0.0, 0.5})), 4.0);
}

TEST(RightOfWay, LeavesTheStripItStandsInWhenThereIsTime) {
  // He comes through the robot's place in six seconds; by then it is 1.5 m away.
  EXPECT_DOUBLE_EQ(lengthFor(walker({0.0, -2.4}, {0.0, 0.4})), 4.0);
}

TEST(RightOfWay, StandsStillWhereDrivingBringsItNearer) {
  // He passes 0.6 m before the robot right now.
  EXPECT_DOUBLE_EQ(lengthFor(walker({0.7, -0.5}, {0.0, 0.5})), 0.0);
}

TEST(RightOfWay, OneThatStandsNeedsTimeToGetGoing) {
  // He comes in five seconds to where the robot is; at once at speed it would be 1.2 m on, from a stand 0.3
  // m.
  RightOfWayParams slow;
  slow.accel_mps2 = 0.05;
  const TrackedObstacle coming = walker({0.0, -2.0}, {0.0, 0.4});
  EXPECT_DOUBLE_EQ(lengthFor(coming), 4.0);
  slow.leave_m = 0.3;
  EXPECT_DOUBLE_EQ(lengthToYield(straightPath(4.0), {coming}, kRobotRadius_m, slow, 0.25), 4.0);
  EXPECT_DOUBLE_EQ(lengthToYield(straightPath(4.0), {coming}, kRobotRadius_m, slow, 0.0), 0.0);
}

TEST(RightOfWay, IgnoresOneWhoWalksAway) { EXPECT_DOUBLE_EQ(lengthFor(walker({2.0, 0.0}, {1.0, 0.0})), 4.0); }

TEST(RightOfWay, YieldsToTheFirstOfSeveral) {
  const double length =
      lengthToYield(straightPath(4.0), {walker({2.5, -2.0}, {0.0, 0.3}), walker({1.5, -2.0}, {0.0, 0.5})},
                    kRobotRadius_m, RightOfWayParams{});
  EXPECT_NEAR(length, 0.75, 0.05 + 1e-9);
}

TEST(RightOfWay, KeepsFartherFromAnUncertainOne) {
  TrackedObstacle vague = walker({1.5, -2.0}, {0.0, 0.5});
  vague.covariance.topLeftCorner<2, 2>() = 0.15 * 0.15 * Eigen::Matrix2d::Identity();
  EXPECT_NEAR(lengthFor(vague), 1.5 - 0.75 - 0.15, 0.05 + 1e-9);
}

}  // namespace
}  // namespace frugal_nav
