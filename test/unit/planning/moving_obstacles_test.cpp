#include "flat_world.hpp"

#include <gtest/gtest.h>

#include <frugal_nav/planning/active_window.hpp>
#include <frugal_nav/planning/lidar_avoidance.hpp>

namespace frugal_nav {
namespace {

using planning_test::FlatWorld;
using planning_test::kBody;

constexpr double kPeriod_s = 0.1;
constexpr double kHalf_m = 0.15;  // of the box that moves

/// A room of 8 m x 6 m with a post, and a box at a place.
FlatWorld roomWith(const Eigen::Vector2d& box) {
  return FlatWorld()
      .box(-2.0, -3.0, 6.0, 3.0)
      .box(0.9, 1.8, 1.1, 2.0)
      .box(box.x() - kHalf_m, box.y() - kHalf_m, box.x() + kHalf_m, box.y() + kHalf_m);
}

class MovingObstaclesTest : public testing::Test {
 protected:
  /// Scans from the origin while the box moves from `begin`; where it is then.
  Eigen::Vector2d watch(const Eigen::Vector2d& begin, const Eigen::Vector2d& velocity_mps,
                        double duration_s) {
    Eigen::Vector2d box = begin;
    for (double t = 0.0; t < duration_s - 1e-9; t += kPeriod_s, time_s_ += kPeriod_s) {
      box = begin + t * velocity_mps;
      window.update(roomWith(box).scan({}, time_s_), {}, {0.0, 0.0});
    }
    return box;
  }
  bool isOccupied(const Eigen::Vector2d& p) const {
    return window.grid().state(window.grid().cellOf(p)) == RollingGrid::State::kOccupied;
  }

  ActiveWindow window{RollingGridParams{}};

 private:
  double time_s_ = 0.0;
};

TEST_F(MovingObstaclesTest, FollowsOneThatCrosses) {
  const Eigen::Vector2d box = watch({1.8, -2.0}, {0.0, 0.8}, 2.0);
  const std::vector<TrackedObstacle>& moving = window.moving().moving();
  ASSERT_EQ(moving.size(), 1U);
  // The side in view lies half the box's size before its middle.
  EXPECT_NEAR(moving.front().p_odom.y(), box.y(), 0.15);
  EXPECT_NEAR(moving.front().p_odom.x(), box.x() - kHalf_m, 0.15);
  EXPECT_NEAR((moving.front().velocity_mps - Eigen::Vector2d(0.0, 0.8)).norm(), 0.0, 0.2);
}

TEST_F(MovingObstaclesTest, LeavesNoTrailInTheGrid) {
  const Eigen::Vector2d box = watch({1.8, -2.0}, {0.0, 0.8}, 2.0);
  ASSERT_EQ(window.moving().moving().size(), 1U);
  for (double y = -2.2; y <= box.y() + 0.2; y += 0.05) {
    for (double x = 1.6; x <= 2.0; x += 0.05) EXPECT_FALSE(isOccupied({x, y})) << x << ", " << y;
  }
  EXPECT_FALSE(window.pointsWithin(box, 0.3).empty()) << "what the last scan saw of it counts";
  EXPECT_TRUE(isOccupied({0.98, 1.8 + 0.01}) || isOccupied({0.98, 1.8 - 0.01})) << "the post stays";
}

TEST_F(MovingObstaclesTest, OneThatStopsIsAnObstacleAgain) {
  const Eigen::Vector2d box = watch({1.8, -2.0}, {0.0, 0.8}, 2.0);
  watch(box, {0.0, 0.0}, 4.0);
  EXPECT_TRUE(window.moving().moving().empty());
  EXPECT_TRUE(window.moving().newcomers().empty());
  EXPECT_TRUE(isOccupied(box - Eigen::Vector2d(kHalf_m, 0.0)) ||
              isOccupied(box - Eigen::Vector2d(kHalf_m + 0.02, 0.0)));
}

TEST_F(MovingObstaclesTest, WhatStandsDoesNotMoveWhenTheRobotPasses) {
  const FlatWorld world = roomWith({1.8, -0.6});
  for (int k = 0; k < 60; ++k) {
    const Pose2 pose{0.05 * k, 0.3 * std::sin(0.1 * k), 0.4 * std::sin(0.15 * k)};
    window.update(world.scan(pose, kPeriod_s * k), pose, pose.position());
    EXPECT_TRUE(window.moving().moving().empty()) << "at " << pose.x_m;
  }
}

/// Standing at the origin with a goal straight ahead, by a method.
MotionCommand commandWhile(const std::string& method, const Eigen::Vector2d& begin,
                           const Eigen::Vector2d& velocity_mps, double duration_s) {
  LidarAvoidanceParams params;
  params.method = method;
  params.use_path = false;
  LidarAvoidance avoidance(params, kBody);
  avoidance.setGoal(Pose2{4.0, 0.0, 0.0});
  MotionCommand command;
  for (double t = 0.0; t < duration_s - 1e-9; t += kPeriod_s) {
    command = avoidance.update(roomWith(begin + t * velocity_mps).scan({}, t), {}, {});
  }
  return command;
}

TEST(LidarAvoidanceYields, LetsOneWhoCrossesPass) {
  for (const char* method : {"vfh_plus", "vfh_star", "dwa"}) {
    const MotionCommand before = commandWhile(method, {0.65, -2.4}, {0.0, 0.8}, 2.0);
    EXPECT_EQ(before.status, MotionCommand::Status::kDriving) << method;
    EXPECT_EQ(before.holds, MotionCommand::Holds::kNothing);
    EXPECT_EQ(before.reason, "letting a moving obstacle pass");
    const MotionCommand behind = commandWhile(method, {0.65, -2.4}, {0.0, 0.8}, 5.5);
    EXPECT_EQ(behind.status, MotionCommand::Status::kDriving) << method;
    EXPECT_GT(behind.velocity.v_mps, 0.05);
  }
}

TEST(LidarAvoidanceYields, StandsBesideOneWhoCameAndStopped) {
  // He comes to 0.45 m beside the robot and stands there: by prediction he is nobody's obstacle.
  const auto stopped = [](double after_s) {
    LidarAvoidanceParams params;
    params.method = "vfh_star";
    params.use_path = false;
    LidarAvoidance avoidance(params, kBody);
    avoidance.setGoal(Pose2{4.0, 0.0, 0.0});
    MotionCommand command;
    for (double t = 0.0; t < 2.0 + after_s; t += kPeriod_s) {
      const Eigen::Vector2d box(0.0, -2.2 + 0.8 * std::min(t, 2.0));
      command = avoidance.update(roomWith(box).scan({}, t), {}, {});
    }
    return command;
  };
  EXPECT_EQ(stopped(0.9).holds, MotionCommand::Holds::kNothing);
  EXPECT_EQ(stopped(4.0).holds, MotionCommand::Holds::kVelocity);
}

}  // namespace
}  // namespace frugal_nav
