#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unit/planning/flat_world.hpp>

#include <frugal_nav/planning/camera_planner.hpp>
#include <frugal_nav/planning/path_shape.hpp>

namespace frugal_nav {
namespace {

using planning_test::FlatWorld;
using planning_test::kBody;
using ::testing::HasSubstr;
using Status = CameraPlan::Status;
using Vec = Eigen::Vector2d;

/// What a camera without noise sees of a flat world, 62 degrees wide; the gap straight ahead.
CameraObservation observe(const FlatWorld& world, const Pose2& pose, double time_s) {
  CameraObservation seen;
  seen.stamp = seen.gap.stamp = seen.obstacle.stamp = stampFromSeconds(time_s);
  seen.odometry.stamp = seen.stamp;
  seen.odometry.odom_from_base = pose;
  LaserScan all = world.scan(pose, time_s);
  seen.scan = all;
  seen.scan.angle_min_rad = all.angleOf(149);
  seen.scan.ranges_m = {all.ranges_m.begin() + 149, all.ranges_m.begin() + 212};
  seen.gap.found = true;
  seen.gap.p_odom = pose * Vec(1.5, 0.0);
  return seen;
}

class CameraPlannerTest : public ::testing::Test {
 protected:
  static CameraPlannerParams literal() {
    CameraPlannerParams params;
    params.astar.mode = "literal";
    params.astar.cell_m = 0.2;
    return params;
  }
  /// Looks at the world `times` times; the last plan.
  CameraPlan look(CameraPlanner& planner, int times = 1, const Pose2& pose = {}) {
    CameraPlan plan;
    for (int i = 0; i < times; ++i) {
      time_s_ += 0.2;
      CameraObservation seen = observe(world_, pose, time_s_);
      if (change_) change_(seen);
      plan = planner.update(seen);
    }
    return plan;
  }
  /// Sees a wall 1.5 m before the origin as a whole, from close by, and then straight ahead.
  CameraPlan lookAround(CameraPlanner& planner) {
    for (const double yaw : {-1.2, -0.6, 0.6, 1.2}) look(planner, 8, {0.7, 0.0, yaw});
    return look(planner, 8, {0.7, 0.0, 0.0});
  }
  static double clearance(const FlatWorld& world, const Path2& path) {
    double least = 1e9;
    for (std::size_t i = 1; i < path.size(); ++i) {
      for (double f = 0.0; f <= 1.0; f += 0.1)
        least = std::min(least, world.clearance(interpolate(path[i - 1], path[i], f).position()));
    }
    return least;
  }

  FlatWorld world_ = FlatWorld().box(-2.0, -2.5, 7.0, 2.5);
  double time_s_ = 1.0;
  std::function<void(CameraObservation&)> change_;
};

TEST_F(CameraPlannerTest, IdlesWithoutAGoal) {
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  const CameraPlan plan = look(planner);
  EXPECT_EQ(plan.status, Status::kIdle);
  EXPECT_TRUE(plan.path.empty());
  EXPECT_EQ(plan.stamp, stampFromSeconds(time_s_));
}

TEST_F(CameraPlannerTest, DrivesStraightWhereNothingStands) {
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  planner.setGoal(Pose2{4.0, 0.3, 0.0});
  const CameraPlan plan = look(planner);
  ASSERT_EQ(plan.status, Status::kFound);
  EXPECT_TRUE(plan.reaches_goal);
  EXPECT_LT((plan.path.back().position() - Vec(4.0, 0.3)).norm(), 1e-9);
  EXPECT_LT(lengthOf(plan.path), 1.02 * std::hypot(4.0, 0.3));
}

TEST_F(CameraPlannerTest, KeepsItsDistanceFromObstacles) {
  world_.box(1.5, -0.3, 1.9, 0.3);
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  const CameraPlan plan = look(planner, 3);
  ASSERT_EQ(plan.status, Status::kFound);
  // 2.0 robot widths are a quarter metre to each side, less the slack of 0.05 m and a cell of 0.05 m.
  EXPECT_GT(clearance(world_, plan.path), 0.15);
}

TEST_F(CameraPlannerTest, RemembersAnObstacleThatLeftTheView) {
  world_.box(1.5, -0.3, 1.9, 0.3);
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  look(planner, 3);
  const Pose2 turned{0.0, 0.0, 1.2};
  EXPECT_GT(clearance(world_, look(planner, 20, turned).path), 0.15);
}

// A wall from side to side with a doorway of half a metre, seen askew: what is seen through it is narrower
// than the robot with the wall's far side. No other way is open but through what lies unseen behind the
// robot.
TEST_F(CameraPlannerTest, DrivesThroughADoorwayRatherThanFarAroundItsUnseenSide) {
  world_.box(1.5, -2.5, 1.7, -0.25).box(1.5, 0.25, 1.7, 2.5);
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  planner.setGoal(Pose2{3.0, 0.0, 0.0});
  for (const double yaw : {-1.2, -0.4, 1.4}) look(planner, 3, {0.3, -1.0, yaw});
  const CameraPlan plan = look(planner, 3, {0.3, -1.0, 0.7});
  ASSERT_EQ(plan.status, Status::kFound);
  EXPECT_TRUE(plan.reaches_goal);
  EXPECT_LT(lengthOf(plan.path), 4.0);  // 3 m, and what it keeps off the doorway's edges
}

TEST_F(CameraPlannerTest, ThePersonIsNoObstacle) {
  world_.box(3.0, -0.25, 3.3, 0.25);
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  planner.setGoal(Pose2{2.6, 0.0, 0.0}, Vec(3.1, 0.0));
  const CameraPlan plan = look(planner, 3);
  EXPECT_TRUE(plan.reaches_goal);
  CameraPlanner stranger(CameraPlannerParams{}, kBody);
  stranger.setGoal(Pose2{2.85, 0.0, 0.0});
  EXPECT_FALSE(look(stranger, 3).reaches_goal);
}

TEST_F(CameraPlannerTest, DrivesAroundThePersonToItsOtherSide) {
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  const Vec person(2.0, 0.05);
  planner.setGoal(Pose2{2.8, 0.0, 0.0}, person);
  const CameraPlan plan = look(planner);
  ASSERT_TRUE(plan.reaches_goal);
  for (const Pose2& pose : plan.path) EXPECT_GT((pose.position() - person).norm(), 0.4);
}

TEST_F(CameraPlannerTest, DrivesThroughNoGapOfLessThanTwoRobotWidths) {
  // The only way is a gate; 0.40 m are 1.6 robot widths, 0.65 m are 2.6.
  for (const double gate : {0.40, 0.65}) {
    FlatWorld gated = FlatWorld().box(-2.0, -2.5, 7.0, 2.5);
    gated.box(1.5, -2.5, 1.8, -gate / 2).box(1.5, gate / 2, 1.8, 2.5);
    world_ = gated;
    change_ = [gate](CameraObservation& seen) { seen.gap.width_m = gate; };
    CameraPlannerParams params;
    CameraPlanner planner(params, kBody);
    planner.setGoal(Pose2{4.0, 0.0, 0.0});
    const CameraPlan plan = lookAround(planner);
    if (gate < 0.5) {
      EXPECT_EQ(plan.status, Status::kHalted);
      EXPECT_THAT(plan.reason, HasSubstr("0.40 m wide, less than 2.0 robot widths"));
      EXPECT_TRUE(plan.path.empty());
      params.halt_width_factor = 1.5;
      CameraPlanner bolder(params, kBody);
      bolder.setGoal(Pose2{4.0, 0.0, 0.0});
      EXPECT_EQ(lookAround(bolder).status, Status::kFound);
    } else {
      ASSERT_EQ(plan.status, Status::kFound) << plan.reason;
      EXPECT_GT(clearance(world_, plan.path), 0.2);
    }
  }
}

TEST_F(CameraPlannerTest, GoesRoundANarrowGapWhereAnotherWayIsKnown) {
  world_.box(1.5, -0.9, 1.8, -0.17).box(1.5, 0.17, 1.8, 0.9);  // 0.34 m between them, open beside
  change_ = [](CameraObservation& seen) { seen.gap.width_m = 0.34; };
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  const CameraPlan plan = look(planner, 10);  // often enough that there is no doubt
  ASSERT_EQ(plan.status, Status::kFound);
  double aside = 0.0;
  for (const Pose2& pose : plan.path) aside = std::max(aside, std::abs(pose.y_m));
  EXPECT_GT(aside, 0.9);
}

// Facing a wall says nothing of the way beside it: a robot that took it for closed turned to and fro.
TEST_F(CameraPlannerTest, AViewWithoutAGapClosesNoWay) {
  world_.box(1.2, -2.5, 1.4, 2.5);
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  planner.setGoal(Pose2{-1.5, 0.0, 0.0});
  const double with_gap_m = lengthOf(look(planner).path);
  change_ = [](CameraObservation& seen) {
    seen.gap.found = false;
    seen.gap.reason = "everything in view is near";
  };
  const CameraPlan plan = look(planner, 10);
  EXPECT_EQ(plan.status, Status::kFound);
  EXPECT_NEAR(lengthOf(plan.path), with_gap_m, 0.1);
}

TEST_F(CameraPlannerTest, LooksFromNearByAtWhatIsDoubtful) {
  // A wall with a passage, which one look from afar takes for closed.
  world_.box(2.5, -2.5, 2.7, -0.4).box(2.5, 0.4, 2.7, 2.5);
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  for (const double yaw : {-0.8, 0.8}) look(planner, 20, {0.0, 0.0, yaw});
  look(planner, 20);
  change_ = [](CameraObservation& seen) {
    for (float& range : seen.scan.ranges_m) range = std::min(range, 2.5F);
  };
  const CameraPlan plan = look(planner, 2);
  ASSERT_EQ(plan.status, Status::kFound) << plan.reason;
  EXPECT_LT(lengthOf(plan.path), 4.5);
  // The same so often that there is no doubt: another way, or none.
  const CameraPlan sure = look(planner, 20);
  EXPECT_TRUE(sure.path.empty() || lengthOf(sure.path) > 5.0) << lengthOf(sure.path);
  // From near by one look is enough.
  change_ = nullptr;
  CameraPlanner near(CameraPlannerParams{}, kBody);
  near.setGoal(Pose2{4.0, 0.0, 0.0});
  for (const double yaw : {-0.8, 0.8, 0.0}) look(near, 20, {1.9, 0.0, yaw});
  change_ = [](CameraObservation& seen) {
    for (float& range : seen.scan.ranges_m) range = std::min(range, 0.6F);
  };
  const CameraPlan closed = look(near, 2, {1.9, 0.0, 0.0});
  EXPECT_TRUE(closed.path.empty() || lengthOf(closed.path) > 3.0) << lengthOf(closed.path);
}

TEST_F(CameraPlannerTest, SaysThatThereIsNoGapWhereNoOtherWayIsKnown) {
  world_ = FlatWorld().box(-0.9, -0.9, 0.9, 0.9);
  change_ = [](CameraObservation& seen) {
    seen.gap.found = false;
    seen.gap.reason = "everything in view is near";
  };
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  planner.setGoal(Pose2{3.0, 0.0, 0.0});
  for (double yaw = -3.0; yaw < 3.2; yaw += 0.5) look(planner, 8, {0.0, 0.0, yaw});
  const CameraPlan plan = look(planner);
  EXPECT_EQ(plan.status, Status::kHalted);
  EXPECT_THAT(plan.reason, HasSubstr("no gap: everything in view is near, and no other way is known"));
}

TEST_F(CameraPlannerTest, LetsAWalkerPassAndGoesOnBehindHim) {
  CameraPlannerParams params;
  params.right_of_way.cruise_mps = 0.5;  // slower it would come when he has long passed
  CameraPlanner planner(params, kBody);
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  const FlatWorld empty = world_;
  bool yielded = false;
  bool went_on = false;
  for (int n = 0; n < 40; ++n) {
    const double y = -1.0 + 0.08 * n;  // 0.4 m/s
    world_ = empty;
    world_.box(1.6, y - 0.2, 1.9, y + 0.2);
    const CameraPlan plan = look(planner);
    EXPECT_EQ(plan.status == Status::kFound, !plan.path.empty());
    if (plan.yields) {
      yielded = true;
      EXPECT_TRUE(plan.path.empty() || plan.path.back().x_m < 1.4);
    }
    if (y > 1.3) went_on = went_on || plan.reaches_goal;
  }
  EXPECT_TRUE(yielded);
  EXPECT_TRUE(went_on);
}

TEST_F(CameraPlannerTest, ReplansWhenItMustAndOtherwiseKeepsItsPath) {
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  planner.setGoal(Pose2{5.0, 0.0, 0.0});
  EXPECT_EQ(look(planner).replanned, "no path yet");
  EXPECT_EQ(look(planner).replanned, "");
  planner.setGoal(Pose2{5.0, 0.05, 0.0});
  EXPECT_EQ(look(planner).replanned, "");
  planner.setGoal(Pose2{5.0, 0.3, 0.0});
  EXPECT_EQ(look(planner).replanned, "the goal moved");
  change_ = [](CameraObservation& seen) { seen.gap.p_odom.y() += 0.5; };
  EXPECT_EQ(look(planner).replanned, "the gap changed");
  EXPECT_EQ(look(planner).replanned, "");
  change_ = [](CameraObservation& seen) {
    seen.gap.p_odom.y() += 0.5;
    seen.obstacle.found = true;
    seen.obstacle.p_odom = {0.9, 0.7};
    seen.obstacle.sigma_m = 0.05;
  };
  EXPECT_EQ(look(planner).replanned, "an obstacle is near");
  EXPECT_EQ(look(planner).replanned, "");
  EXPECT_EQ(look(planner, 1, {0.3, -0.3, 0.0}).replanned, "off the path");
  look(planner, 4, {0.3, -0.3, 0.0});
  EXPECT_EQ(look(planner, 1, {0.3, -0.3, 0.0}).replanned, "time");  // a second later
  world_.box(1.2, -0.5, 1.5, 0.2);
  EXPECT_EQ(look(planner, 1, {0.3, -0.3, 0.0}).replanned, "the path is blocked");
}

TEST_F(CameraPlannerTest, DoesNotSwingBackAtOnce) {
  // Past an obstacle on the line to a goal far ahead: half a metre on, the path is still well aside.
  CameraPlannerParams params;
  CameraPlanner planner(params, kBody);
  planner.setGoal(Pose2{6.0, 0.0, 0.0});
  world_.box(1.0, -0.3, 1.3, 0.3);
  const CameraPlan plan = look(planner, 3);
  ASSERT_EQ(plan.status, Status::kFound);
  const auto asideAt = [](const Path2& path, double x) {
    for (const Pose2& pose : path) {
      if (pose.x_m >= x) return std::abs(pose.y_m);
    }
    return 0.0;
  };
  CameraPlannerParams plain;
  plain.astar.kappa = 0.0;
  CameraPlanner direct(plain, kBody);
  direct.setGoal(Pose2{6.0, 0.0, 0.0});
  const CameraPlan swinging = look(direct, 3);
  EXPECT_GT(asideAt(plan.path, 2.0), 0.35);
  EXPECT_GE(asideAt(plan.path, 3.0) + 1e-6, asideAt(swinging.path, 3.0));
}

TEST_F(CameraPlannerTest, LiteralHaltsWithoutAGapOrAtANarrowOne) {
  CameraPlanner planner(literal(), kBody);
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  EXPECT_EQ(look(planner).status, Status::kFound);
  change_ = [](CameraObservation& seen) { seen.gap.width_m = 0.45; };
  EXPECT_EQ(look(planner).status, Status::kHalted);
  change_ = [](CameraObservation& seen) { seen.gap.found = false; };
  const CameraPlan plan = look(planner);
  EXPECT_EQ(plan.status, Status::kHalted);
  EXPECT_TRUE(plan.path.empty());
}

TEST_F(CameraPlannerTest, LiteralKnowsTheNearestObstacleOnly) {
  change_ = [](CameraObservation& seen) {
    seen.obstacle.found = true;
    seen.obstacle.p_odom = {1.2, 0.0};
    seen.gap.p_odom = {1.2, 0.6};
  };
  CameraPlanner planner(literal(), kBody);
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  const CameraPlan plan = look(planner);
  ASSERT_EQ(plan.status, Status::kFound);
  double nearest = 1e9;
  for (const Pose2& pose : plan.path) nearest = std::min(nearest, (pose.position() - Vec(1.2, 0.0)).norm());
  EXPECT_GT(nearest, kBody.circumradius_m);
}

TEST_F(CameraPlannerTest, StopsOnWhatCannotBeUsed) {
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  const auto reasonWith = [&](const std::function<void(CameraObservation&)>& change) {
    change_ = nullptr;
    EXPECT_EQ(look(planner).status, Status::kFound);
    change_ = change;
    const CameraPlan plan = look(planner);
    EXPECT_EQ(plan.status, Status::kStopped);
    EXPECT_TRUE(plan.path.empty());
    return plan.reason;
  };
  const double nan = std::nan("");
  EXPECT_EQ(reasonWith([](CameraObservation& seen) { seen.fault = "the image is dark"; }),
            "the image is dark");
  EXPECT_THAT(reasonWith([](CameraObservation& seen) { seen.scan.ranges_m.clear(); }), HasSubstr("scan"));
  EXPECT_THAT(reasonWith([nan](CameraObservation& seen) { seen.odometry.odom_from_base.x_m = nan; }),
              HasSubstr("pose"));
  EXPECT_THAT(reasonWith([nan](CameraObservation& seen) { seen.gap.p_odom.x() = nan; }), HasSubstr("gap"));
  EXPECT_THAT(reasonWith([nan](CameraObservation& seen) {
                seen.obstacle.found = true;
                seen.obstacle.p_odom = {nan, 0.0};
              }),
              HasSubstr("obstacle"));
  change_ = nullptr;
  planner.setGoal(Pose2{nan, 0.0, 0.0});
  EXPECT_EQ(look(planner).status, Status::kStopped);
}

TEST_F(CameraPlannerTest, ForgetsOnResetAndOnlyThen) {
  world_.box(1.5, -0.3, 1.9, 0.3);
  CameraPlanner planner(CameraPlannerParams{}, kBody);
  planner.setGoal(Pose2{4.0, 0.0, 0.0});
  look(planner, 3);
  planner.setParams(CameraPlannerParams{});
  EXPECT_EQ(planner.memory().grid().state(planner.memory().grid().cellOf({1.51, 0.0})),
            RollingGrid::State::kOccupied);
  planner.reset();
  EXPECT_EQ(planner.memory().grid().state(planner.memory().grid().cellOf({1.51, 0.0})),
            RollingGrid::State::kUnknown);
  time_s_ = 0.5;  // an earlier time
  EXPECT_EQ(look(planner).status, Status::kFound);
}

TEST(CameraPlannerParams, AreChecked) {
  CameraPlannerParams params;
  params.halt_width_factor = 0.5;
  EXPECT_THROW(CameraPlanner(params, kBody), ConfigError);
  params = {};
  params.astar.mode = "other";
  EXPECT_THROW(CameraPlanner(params, kBody), ConfigError);
  params = {};
  params.doubtful_certainty = params.memory.grid.max_certainty;
  EXPECT_THROW(CameraPlanner(params, kBody), ConfigError);
}

}  // namespace
}  // namespace frugal_nav
