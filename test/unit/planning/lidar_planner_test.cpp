#include "flat_world.hpp"

#include <gtest/gtest.h>

#include <frugal_nav/planning/lidar_planner.hpp>
#include <frugal_nav/planning/path_shape.hpp>

namespace frugal_nav {
namespace {

using planning_test::FlatWorld;
using planning_test::kBody;
using Status = LidarPlan::Status;

double leastClearance(const FlatWorld& world, const Path2& path) {
  double least = 1e9;
  for (std::size_t i = 1; i < path.size(); ++i) {
    for (double f = 0.0; f <= 1.0; f += 0.1) {
      least = std::min(least, world.clearance(interpolate(path[i - 1], path[i], f).position()));
    }
  }
  return least;
}

class LidarPlannerTest : public testing::Test {
 protected:
  LidarPlan planFrom(const FlatWorld& world, const Pose2& pose, double stamp_s = 0.0) {
    return planner.update(world.scan(pose, stamp_s), {}, pose);
  }

  LidarPlannerParams params;
  LidarPlanner planner{params, kBody};
  // 7 m x 5 m, the robot starts in its left part.
  const FlatWorld room = FlatWorld().box(-1.0, -2.5, 6.0, 2.5);
};

TEST_F(LidarPlannerTest, IdlesWithoutGoal) {
  const LidarPlan plan = planFrom(room, {}, 3.0);
  EXPECT_EQ(plan.status, Status::kIdle);
  EXPECT_TRUE(plan.path.empty());
  EXPECT_EQ(plan.stamp, stampFromSeconds(3.0));
}

TEST_F(LidarPlannerTest, StraightThroughFreeSpace) {
  planner.setGoal(Pose2{4.0, 0.7, 0.0});
  const LidarPlan plan = planFrom(room, {});
  ASSERT_EQ(plan.status, Status::kFound) << plan.reason;
  EXPECT_TRUE(plan.reaches_goal);
  EXPECT_EQ(plan.path.front().x_m, 0.0);
  EXPECT_EQ(plan.path.back().x_m, 4.0);
  EXPECT_EQ(plan.path.back().y_m, 0.7);
  // The line itself is within two cells' widths of what eight directions and centres allow.
  EXPECT_NEAR(lengthOf(plan.path), std::hypot(4.0, 0.7), 0.1);
  for (std::size_t i = 1; i < plan.path.size(); ++i) {
    EXPECT_LE(distance(plan.path[i - 1], plan.path[i]), params.path_spacing_m + 1e-9);
  }
}

TEST_F(LidarPlannerTest, OtherParametersLeaveWhatWasSeen) {
  planFrom(room, {});
  const Cell seen = planner.grid().cellOf({3.0, 0.0});
  ASSERT_EQ(planner.grid().state(seen), RollingGrid::State::kFree);
  params.switch_gain = 0.2;
  params.cost.clearance_weight = 2.0;
  params.grid.memory_s = 30.0;
  planner.setParams(params);
  EXPECT_EQ(planner.grid().state(seen), RollingGrid::State::kFree);
  params.grid.cell_m = -1.0;
  EXPECT_THROW(planner.setParams(params), ConfigError);
  EXPECT_EQ(planner.grid().state(seen), RollingGrid::State::kFree) << "nothing changed";
  params.grid.cell_m = 0.1;
  planner.setParams(params);
  EXPECT_EQ(planner.grid().state(planner.grid().cellOf({3.0, 0.0})), RollingGrid::State::kUnknown);
  planner.setGoal(Pose2{4.0, 0.7, 0.0});
  EXPECT_EQ(planFrom(room, {}, 0.1).status, Status::kFound) << "it plans in cells of the new size";
}

TEST_F(LidarPlannerTest, GoesAroundABoxWithRoomBesideTheBody) {
  FlatWorld world = room;
  world.box(1.5, -1.0, 2.5, 1.2);
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  const LidarPlan plan = planFrom(world, {});
  ASSERT_EQ(plan.status, Status::kFound) << plan.reason;
  // Lethal distance less half a cell's diagonal at each end.
  EXPECT_GE(leastClearance(world, plan.path), kBody.half_width_m + params.cost.lethal_margin_m - 0.07);
  EXPECT_LT(lengthOf(plan.path), 6.0);
}

TEST_F(LidarPlannerTest, PassesADoorOfSixtyCentimetres) {
  FlatWorld world = room;
  world.box(2.0, -2.5, 2.2, -0.3).box(2.0, 0.3, 2.2, 2.5);
  planner.setGoal(Pose2{4.0, 1.0, 0.0});
  const LidarPlan plan = planFrom(world, {});
  ASSERT_EQ(plan.status, Status::kFound) << plan.reason;
  EXPECT_GE(leastClearance(world, plan.path), 0.23);  // near its middle
}

TEST_F(LidarPlannerTest, RefusesAGapNarrowerThanTheBody) {
  FlatWorld world = room;
  world.box(2.0, -2.5, 2.2, -0.12).box(2.0, 0.12, 2.2, 2.5);
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  // Near by: from afar the beams leave the gap's width open by their spacing.
  const LidarPlan plan = planFrom(world, {1.5, 0.0, 0.0});
  EXPECT_EQ(plan.status, Status::kNoPath);
  EXPECT_TRUE(plan.path.empty());
  EXPECT_EQ(plan.reason, "no way to the goal through what is seen and remembered");
}

TEST_F(LidarPlannerTest, LeadsStraightThroughTheMiddleOfADoorThatTheBodyJustFits) {
  // 0.29 m: the body's 0.25 m and 4 cm, less than the grid's cells can tell from 0.24 m.
  FlatWorld world = room;
  world.box(2.0, -2.5, 2.1, -0.125).box(2.0, 0.165, 2.1, 2.5);
  planner.setGoal(Pose2{4.0, 1.0, 0.0});
  const LidarPlan plan = planFrom(world, {1.2, 0.6, 0.0});
  ASSERT_EQ(plan.status, Status::kFound) << plan.reason;
  for (const Pose2& pose : plan.path) {
    // The spacing of the beams, 1 degree at 0.9 m, leaves half of 1.6 cm open to each side.
    if (pose.x_m > 1.7 && pose.x_m < 2.2) {
      EXPECT_NEAR(pose.y_m, 0.02, 0.03) << pose.x_m;
    }
  }
}

TEST_F(LidarPlannerTest, GoesBesideAGoalAtTheEdgeOfABox) {
  FlatWorld world = room;
  world.box(2.0, -1.0, 3.0, 1.0);
  planner.setGoal(Pose2{1.9, 0.0, 0.0});
  const LidarPlan plan = planFrom(world, {});
  ASSERT_EQ(plan.status, Status::kFound);
  EXPECT_FALSE(plan.reaches_goal);
  EXPECT_LE(distance(plan.path.back(), {1.9, 0.0, 0.0}), params.goal_tolerance_m + 0.05);
}

TEST_F(LidarPlannerTest, NamesAGoalInAnObstacle) {
  FlatWorld world = room;
  world.box(2.0, -0.5, 2.3, 0.5);
  planner.setGoal(Pose2{2.15, 0.0, 0.0});
  planFrom(world, {4.0, 0.0, 0.0}, 0.0);  // its far side is seen too: what is inside is no secret passage
  const LidarPlan plan = planFrom(world, {}, 0.1);
  EXPECT_EQ(plan.status, Status::kNoPath);
  EXPECT_EQ(plan.reason, "the goal lies in an obstacle");
}

TEST_F(LidarPlannerTest, GoalOutsideTheWindowLeadsToTheBorderAroundObstacles) {
  FlatWorld world;  // a wall across the straight way where the window ends
  world.box(4.6, -1.5, 4.9, 1.5);
  planner.setGoal(Pose2{20.0, 0.0, 0.0});
  const LidarPlan plan = planFrom(world, {});
  ASSERT_EQ(plan.status, Status::kFound) << plan.reason;
  EXPECT_FALSE(plan.reaches_goal);
  EXPECT_GE(leastClearance(world, plan.path), 0.12);
  EXPECT_GT(std::abs(plan.path.back().y_m), 1.5);
}

TEST_F(LidarPlannerTest, LeavesTheInflationItStartsIn) {
  FlatWorld world = room;
  const Pose2 beside_wall{0.0, -2.33, 0.0};  // 0.17 m off: lethal at 0.195 m
  planner.setGoal(Pose2{3.0, 0.0, 0.0});
  const LidarPlan plan = planFrom(world, beside_wall);
  ASSERT_EQ(plan.status, Status::kFound) << plan.reason;
  EXPECT_GE(leastClearance(world, plan.path), 0.12);
  EXPECT_TRUE(plan.reaches_goal);
}

TEST_F(LidarPlannerTest, RemembersAnObstacleOutOfView) {
  // A scanner that only looks ahead sees the box, turns away and still plans around it.
  FlatWorld world = room;
  world.box(1.5, -0.3, 2.0, 0.3);
  const auto ahead = [&world](const Pose2& pose, double stamp_s) {
    LaserScan scan = world.scan(pose, stamp_s);
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      if (std::abs(scan.angleOf(i)) > 1.0) scan.ranges_m[i] = std::numeric_limits<float>::quiet_NaN();
    }
    return scan;
  };
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  planner.update(ahead({}, 0.0), {}, {});
  const Pose2 away{0.0, 0.0, M_PI};
  const LidarPlan remembered = planner.update(ahead(away, 15.0), {}, away);
  ASSERT_EQ(remembered.status, Status::kFound);
  EXPECT_GE(leastClearance(world, remembered.path), 0.1);
  const LidarPlan forgotten = planner.update(ahead(away, 40.0), {}, away);
  ASSERT_EQ(forgotten.status, Status::kFound);
  EXPECT_LT(leastClearance(world, forgotten.path), 0.05);
}

TEST_F(LidarPlannerTest, KeepsItsWayBetweenTwoEqualOnes) {
  FlatWorld world = room;
  world.box(2.0, -0.6, 2.4, 0.6);
  planner.setGoal(Pose2{4.5, 0.0, 0.0});
  // Once decided, swaying about the middle changes nothing.
  const bool left = planFrom(world, {0.0, 0.05, 0.0}).path[20].y_m > 0.0;
  for (int i = 1; i <= 20; ++i) {
    const Pose2 pose{0.03 * i, i % 2 == 0 ? 0.08 : -0.08, 0.0};
    const LidarPlan plan = planFrom(world, pose, 0.1 * i);
    ASSERT_EQ(plan.status, Status::kFound);
    double widest = 0.0;
    for (const Pose2& p : plan.path) widest = std::abs(p.y_m) > std::abs(widest) ? p.y_m : widest;
    ASSERT_EQ(widest > 0.0, left) << "scan " << i;
  }
}

TEST_F(LidarPlannerTest, ANewGoalOwesNothingToTheOldWay) {
  FlatWorld world = room;
  world.box(2.0, -0.6, 2.4, 0.6);
  planner.setGoal(Pose2{4.5, 0.8, 0.0});
  const LidarPlan left = planFrom(world, {});
  planner.setGoal(Pose2{4.5, -0.15, 0.0});
  const LidarPlan right = planFrom(world, {}, 0.1);
  EXPECT_GT(left.path[left.path.size() / 2].y_m, 0.0);
  EXPECT_LT(right.path[right.path.size() / 2].y_m, 0.0);
}

TEST_F(LidarPlannerTest, TakesTheOtherWayWhenItsOwnIsClosed) {
  FlatWorld open = room;
  open.box(2.0, -2.5, 2.4, -1.2).box(2.0, -0.5, 2.4, 1.2);  // doors below and above
  planner.setGoal(Pose2{4.5, 0.0, 0.0});
  const LidarPlan before = planFrom(open, {0.0, -0.4, 0.0});
  FlatWorld closed = open;
  closed.box(2.0, -1.2, 2.4, -0.5);
  const LidarPlan after = planFrom(closed, {0.0, -0.4, 0.0}, 0.1);
  ASSERT_EQ(before.status, Status::kFound);
  ASSERT_EQ(after.status, Status::kFound) << after.reason;
  EXPECT_LT(before.path[before.path.size() / 2].y_m, 0.0);
  EXPECT_GT(after.path[after.path.size() / 2].y_m, 1.0);
}

TEST_F(LidarPlannerTest, NamesWhatIsWrongWithAScan) {
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  LaserScan scan = room.scan({}, 1.0);
  scan.ranges_m.assign(360, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(planner.update(scan, {}, {}).status, Status::kStopped);
  EXPECT_EQ(planner.update(scan, {}, {}).reason, "every range is NaN or beyond range_max");
  scan.ranges_m.clear();
  EXPECT_EQ(planner.update(scan, {}, {}).reason, "the scan is empty");
  EXPECT_EQ(planner.update(room.scan({}), {}, {std::nan(""), 0.0, 0.0}).status, Status::kStopped);
  planner.setGoal(Pose2{std::nan(""), 0.0, 0.0});
  EXPECT_EQ(planFrom(room, {}).reason, "the goal is not finite, or farther off than 1000 km");
}

TEST_F(LidarPlannerTest, WhatMovesIsSaidAndDoesNotBendThePath) {
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  LidarPlan plan;
  for (int i = 0; i < 26; ++i) {  // it crosses at 0.8 m/s, and is on the straight way in the end
    const double y = -2.0 + 0.08 * i;
    FlatWorld crossed = room;
    plan = planFrom(crossed.box(1.5, y - 0.15, 1.8, y + 0.15), {}, 0.1 * i);
  }
  ASSERT_EQ(plan.moving.size(), 1U);
  EXPECT_GT(plan.moving.front().velocity_mps.y(), 0.5);
  ASSERT_EQ(plan.status, Status::kFound);
  for (const Pose2& pose : plan.path) EXPECT_NEAR(pose.y_m, 0.0, 0.06);
}

TEST_F(LidarPlannerTest, ResetForgetsWhatWasSeen) {
  planFrom(room, {});
  planner.reset();
  EXPECT_EQ(planner.grid().state({10, 0}), RollingGrid::State::kUnknown);
  planner.setGoal(Pose2{3.0, 0.0, 0.0});
  EXPECT_EQ(planFrom(room, {}, 0.0).status, Status::kFound);  // an older stamp is no harm then
}

TEST(PathShape, StraightensAStaircase) {
  WeightGrid grid{20, std::vector<std::uint16_t>(400, WeightGrid::kFree)};
  std::vector<Cell> stairs;
  for (int i = 0; i < 8; ++i) stairs.insert(stairs.end(), {{i, i}, {i + 1, i}});
  EXPECT_EQ(straighten(grid, stairs).size(), 2U);
}

TEST(PathShape, KeepsTheDetourThatClearanceIsWorth) {
  // A dear strip (near an obstacle) lies on the chord of the detour.
  WeightGrid grid{20, std::vector<std::uint16_t>(400, WeightGrid::kFree)};
  for (int x = 6; x <= 12; ++x) grid.weights[grid.index({x, 5})] = 300;
  AStar astar;
  const AStarResult found = astar.search(grid, {2, 5}, {16, 5}, 0.0);
  for (const Cell cell : found.cells) ASSERT_NE(grid.weights[grid.index(cell)], 300);
  const std::vector<Cell> corners = straighten(grid, found.cells);
  EXPECT_GT(corners.size(), 2U);
  for (const Cell corner : corners) EXPECT_NE(grid.weights[grid.index(corner)], 300);
}

}  // namespace
}  // namespace frugal_nav
