#include "flat_world.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include <frugal_nav/planning/corridor.hpp>
#include <frugal_nav/planning/lidar_avoidance.hpp>
#include <frugal_nav/planning/lidar_planner.hpp>

namespace frugal_nav {
namespace {

using planning_test::FlatWorld;
using planning_test::kBody;
using Status = MotionCommand::Status;
using Holds = MotionCommand::Holds;

Odometry odometryAt(const Pose2& pose) {
  Odometry odometry;
  odometry.odom_from_base = pose;
  return odometry;
}

/// The method whose commands say where they aim.
LidarAvoidanceParams sectorMethod() {
  LidarAvoidanceParams params;
  params.method = "sectors";
  return params;
}

/// Points every 0.1 m along straight lines.
Path2 pathThrough(const std::vector<Eigen::Vector2d>& corners) {
  Path2 path;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const int pieces = static_cast<int>(std::lround((corners[i + 1] - corners[i]).norm() / 0.1));
    for (int k = 0; k <= pieces; ++k) {
      const Eigen::Vector2d p = corners[i] + (corners[i + 1] - corners[i]) * k / pieces;
      path.push_back({p.x(), p.y(), 0.0});
    }
  }
  return path;
}

class LidarAvoidanceTest : public testing::Test {
 protected:
  MotionCommand update(const Pose2& pose, double stamp_s = 0.0) {
    return avoidance.update(world.scan(pose, stamp_s), {}, odometryAt(pose));
  }

  LidarAvoidanceParams params = sectorMethod();
  LidarAvoidance avoidance{params, kBody};
  FlatWorld world = FlatWorld().box(-3.0, -3.0, 6.0, 3.0);
};

TEST_F(LidarAvoidanceTest, IdlesWithoutGoalButKnowsTheClearSide) {
  world.wall(0.6, -3.0, 0.6, 3.0).wall(-3.0, -0.6, 0.6, -0.6);
  const MotionCommand command = update({}, 1.5);
  EXPECT_EQ(command.status, Status::kIdle);
  EXPECT_EQ(command.holds, Holds::kNothing);
  EXPECT_EQ(command.stamp, stampFromSeconds(1.5));
  EXPECT_GT(command.clear_bearing_rad, 1.5);
}

TEST_F(LidarAvoidanceTest, FollowsThePathToItsLookAheadPoint) {
  avoidance.setGoal(Pose2{3.0, 2.0, 0.0});
  avoidance.setPath(stampFromSeconds(0.0), pathThrough({{0, 0}, {0, 2}, {3, 2}}));
  const MotionCommand command = update({0.0, 0.0, M_PI / 2});
  EXPECT_EQ(command.status, Status::kDriving);
  EXPECT_NEAR(command.odom_from_target.x_m, 0.0, 1e-9);
  EXPECT_NEAR(command.odom_from_target.y_m, 0.5, 1e-9);  // a step toward the point 0.8 m along
}

TEST_F(LidarAvoidanceTest, LooksNoFartherThanItSees) {
  // Round the corner of a wall: the point 0.8 m along lies behind it.
  world.box(-2.0, 0.4, -0.25, 2.0);
  avoidance.setGoal(Pose2{-0.7, 0.1, 0.0});
  const Path2 corner = pathThrough({{0.0, 1.0}, {0.0, 0.1}, {-0.8, 0.1}});
  avoidance.setPath(stampFromSeconds(0.0), corner);
  const MotionCommand command = update({0.0, 0.6, -M_PI / 2});
  ASSERT_EQ(command.status, Status::kDriving);
  // Down along the wall, not across its corner.
  EXPECT_GT(command.odom_from_target.x_m, -0.12);
  EXPECT_LT(command.odom_from_target.y_m, 0.45);
}

TEST_F(LidarAvoidanceTest, HeadsForTheGoalWithoutAPathWhenToldSo) {
  params.use_path = false;
  avoidance = LidarAvoidance(params, kBody);
  avoidance.setGoal(Pose2{0.0, -2.0, 0.0});
  const MotionCommand command = update({});
  EXPECT_EQ(command.status, Status::kDriving);
  EXPECT_NEAR(command.odom_from_target.y_m, -0.5, 1e-9);
}

TEST_F(LidarAvoidanceTest, StopsWithoutAPath) {
  avoidance.setGoal(Pose2{3.0, 0.0, 0.0});
  const MotionCommand none = update({}, 1.0);
  EXPECT_EQ(none.status, Status::kStopped);
  EXPECT_EQ(none.reason, "no path from the planner yet");
  avoidance.setPath(stampFromSeconds(1.0), pathThrough({{0, 0}, {3, 0}}));
  EXPECT_EQ(update({}, 1.5).status, Status::kDriving);
  const MotionCommand stale = update({}, 1.51);
  EXPECT_EQ(stale.status, Status::kStopped);
  EXPECT_EQ(stale.holds, Holds::kNothing);
  EXPECT_EQ(stale.reason, "no path from the planner for 0.51 s");
}

TEST_F(LidarAvoidanceTest, EmptyPathIsABlockedWay) {
  avoidance.setGoal(Pose2{3.0, 0.0, 0.0});
  avoidance.setPath(stampFromSeconds(1.0), {});
  const MotionCommand command = update({}, 1.0);
  EXPECT_EQ(command.status, Status::kBlocked);
  EXPECT_EQ(command.holds, Holds::kNothing);
  EXPECT_EQ(command.reason, "the planner has no path to the goal");
}

TEST_F(LidarAvoidanceTest, NamesBadInputs) {
  avoidance.setGoal(Pose2{3.0, 0.0, 0.0});
  avoidance.setPath(stampFromSeconds(0.0), pathThrough({{0, 0}, {3, 0}}));
  LaserScan scan = world.scan({});
  scan.angle_increment_rad = 0.0;
  MotionCommand command = avoidance.update(scan, {}, odometryAt({}));
  EXPECT_EQ(command.status, Status::kStopped);
  EXPECT_EQ(command.reason, "angle_increment is zero");
  command = avoidance.update(world.scan({}), {}, odometryAt({std::nan(""), 0.0, 0.0}));
  EXPECT_EQ(command.reason, "the odometry is not finite, or farther off than 1000 km");
  command = avoidance.update(world.scan({}), {}, odometryAt({1e12, 0.0, 0.0}));
  EXPECT_EQ(command.reason, "the odometry is not finite, or farther off than 1000 km");
  command = avoidance.update(world.scan({}), {std::nan(""), 0.0, 0.0}, odometryAt({}));
  EXPECT_EQ(command.reason, "the laser's pose is not finite");
  avoidance.setPath(stampFromSeconds(0.0), {{std::nan(""), 0.0, 0.0}});
  EXPECT_EQ(update({}).reason, "the path is not finite");
  avoidance.setGoal(Pose2{std::nan(""), 0.0, 0.0});
  EXPECT_EQ(update({}).reason, "the goal is not finite, or farther off than 1000 km");
}

/// The histogram methods and DWA, which decide on what is remembered too.
class WindowMethodTest : public testing::TestWithParam<const char*> {
 protected:
  WindowMethodTest() {
    params.method = GetParam();
    params.use_path = false;
    avoidance = std::make_unique<LidarAvoidance>(params, kBody);
    avoidance->setGoal(Pose2{2.5, 0.0, 0.0});
  }
  /// A scan that says nothing from -width to width ahead.
  LaserScan blinded(double stamp_s, double width_rad) const {
    LaserScan scan = room.scan({}, stamp_s);
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      if (std::abs(wrapAngle(scan.angleOf(i))) < width_rad) scan.ranges_m[i] = std::nanf("");
    }
    return scan;
  }

  LidarAvoidanceParams params;
  std::unique_ptr<LidarAvoidance> avoidance;
  FlatWorld room = FlatWorld().box(-3.0, -3.0, 6.0, 3.0);
};

TEST_P(WindowMethodTest, DoesNotDriveWhereTheScanSaysNothing) {
  const MotionCommand command = avoidance->update(blinded(0.0, 1.0), {}, odometryAt({}));
  EXPECT_EQ(command.velocity.v_mps, 0.0);
  const MotionCommand seen = avoidance->update(room.scan({}, 0.1), {}, odometryAt({}));
  EXPECT_GT(seen.velocity.v_mps, 0.0);
  const MotionCommand remembered = avoidance->update(blinded(0.2, 0.3), {}, odometryAt({}));
  EXPECT_GT(remembered.velocity.v_mps, 0.0) << "it was free a moment ago";
}

TEST_P(WindowMethodTest, RemembersFreeSpaceWhenParametersChange) {
  avoidance->update(room.scan({}, 0.0), {}, odometryAt({}));
  params.speed.gentle_rad = 0.1;
  avoidance->setParams(params);
  const MotionCommand command = avoidance->update(blinded(0.1, 0.3), {}, odometryAt({}));
  EXPECT_GT(command.velocity.v_mps, 0.0) << "what is not known would stop it";
}

TEST_P(WindowMethodTest, RemembersObstaclesWhenParametersChange) {
  const FlatWorld post = FlatWorld(room).box(0.45, -0.1, 0.55, 0.1);
  avoidance->update(post.scan({}, 0.0), {}, odometryAt({}));
  params.speed.gentle_rad = 0.1;
  avoidance->setParams(params);
  avoidance->setGoal(Pose2{2.5, 0.0, 0.0});
  const MotionCommand command = avoidance->update(blinded(0.1, 0.5), {}, odometryAt({}));
  EXPECT_LT(command.velocity.v_mps, 0.2);
}

INSTANTIATE_TEST_SUITE_P(Methods, WindowMethodTest, testing::Values("vfh_plus", "vfh_star", "dwa"));

TEST_F(LidarAvoidanceTest, ShowsTheDirectionsItChoseFrom) {
  params.method = "vfh_star";
  avoidance = LidarAvoidance(params, kBody);
  avoidance.setGoal(Pose2{3.0, 0.0, 0.0});
  avoidance.setPath(stampFromSeconds(0.0), pathThrough({{0, 0}, {3, 0}}));
  world.box(0.6, -0.3, 0.9, 0.3);
  update({0.0, 0.0, 0.5});
  const auto shown = avoidance.directions(0.5);
  ASSERT_TRUE(shown && shown->found);
  EXPECT_TRUE(std::any_of(shown->candidates_rad.begin(), shown->candidates_rad.end(), [&](double candidate) {
    return std::abs(angleBetween(candidate, shown->bearing_rad)) < 1e-9;
  }));
}

class LidarAvoidanceMethod : public LidarAvoidanceTest, public testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override {
    params.method = GetParam();
    avoidance = LidarAvoidance(params, kBody);
    avoidance.setGoal(Pose2{3.0, 0.0, 0.0});
    avoidance.setPath(stampFromSeconds(0.0), pathThrough({{0, 0}, {3, 0}}));
  }
  /// Drives, stops for the reason when a scan is spoilt, and drives on with the next.
  void expectStop(const std::string& reason, const std::function<void(LaserScan&)>& spoil) {
    ASSERT_EQ(update({}).status, Status::kDriving) << "before: " << reason;
    LaserScan scan = world.scan({});
    spoil(scan);
    const MotionCommand command = avoidance.update(scan, {}, odometryAt({}));
    EXPECT_EQ(command.status, Status::kStopped);
    EXPECT_EQ(command.holds, Holds::kNothing);
    EXPECT_TRUE(command.velocity.isZero());
    EXPECT_NE(command.reason.find(reason), std::string::npos) << command.reason;
    EXPECT_EQ(update({}).status, Status::kDriving) << "after: " << reason;
  }
};

TEST_P(LidarAvoidanceMethod, StopsForABadScanAndDrivesOnAfterIt) {
  const auto all = [](float range) {
    return [range](LaserScan& scan) { std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), range); };
  };
  expectStop("NaN", all(std::nanf("")));
  expectStop("below range_min", all(0.0F));
  expectStop("empty", [](LaserScan& scan) { scan.ranges_m.clear(); });
  expectStop("angle_increment is zero", [](LaserScan& scan) { scan.angle_increment_rad = 0.0; });
  expectStop("more than 360", [](LaserScan& scan) { scan.angle_increment_rad *= 3.0; });
  expectStop("not finite", [](LaserScan& scan) { scan.angle_min_rad = std::nan(""); });
}

TEST_P(LidarAvoidanceMethod, AScanWithoutReturnsIsOpenSpace) {
  LaserScan scan = world.scan({});
  std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), std::numeric_limits<float>::infinity());
  EXPECT_EQ(avoidance.update(scan, {}, odometryAt({})).status, Status::kDriving) << "by REP 117";
}

TEST_P(LidarAvoidanceMethod, AGoalInAnObstacleIsABlockedWayUntilThereIsAnother) {
  ASSERT_EQ(update({}).status, Status::kDriving);
  avoidance.setPath(stampFromSeconds(0.0), {});  // what the planner has for it
  const MotionCommand command = update({});
  EXPECT_EQ(command.status, Status::kBlocked);
  EXPECT_EQ(command.holds, Holds::kNothing);
  EXPECT_NE(command.reason, "");
  avoidance.setPath(stampFromSeconds(0.0), pathThrough({{0, 0}, {3, 0}}));
  EXPECT_EQ(update({}).status, Status::kDriving);
}
INSTANTIATE_TEST_SUITE_P(Methods, LidarAvoidanceMethod,
                         testing::Values("sectors", "vfh_plus", "vfh_star", "dwa"));

TEST_F(LidarAvoidanceTest, ResetForgetsThePath) {
  avoidance.setGoal(Pose2{3.0, 0.0, 0.0});
  avoidance.setPath(stampFromSeconds(100.0), pathThrough({{0, 0}, {3, 0}}));
  avoidance.reset();
  EXPECT_EQ(update({}, 1.0).reason, "no path from the planner yet");
}

TEST(Corridor, IsFreeBesideAndBeyondItsStrip) {
  const Corridor corridor{{1.0, 0.0}, 0.2, 0.1};
  EXPECT_TRUE(isFree(corridor, {{0.5, 0.21}, {0.5, -0.21}, {1.11, 0.0}, {-0.1, 0.0}}));
  EXPECT_FALSE(isFree(corridor, {{0.5, 0.19}}));
  EXPECT_FALSE(isFree(corridor, {{1.09, 0.0}}));
  EXPECT_TRUE(isFree({{0.0, 0.0}, 0.2, 0.1}, {{0.01, 0.0}}));
}

/// A point robot that goes to each target at 0.3 m/s, planned and scanned at 10 Hz. Returns its least
/// distance from a wall, or nothing when it does not arrive within the time.
std::optional<double> driveTo(const FlatWorld& world, const Pose2& goal, double seconds) {
  LidarPlanner planner{LidarPlannerParams{}, kBody};
  LidarAvoidance avoidance{sectorMethod(), kBody};
  planner.setGoal(goal);
  avoidance.setGoal(goal);
  Pose2 pose;
  double least = 1e9;
  for (double t = 0.0; t < seconds; t += 0.1) {
    const LaserScan scan = world.scan(pose, t);
    const LidarPlan plan = planner.update(scan, {}, pose);
    avoidance.setPath(plan.stamp, plan.path);
    const MotionCommand command = avoidance.update(scan, {}, odometryAt(pose));
    if (command.holds == Holds::kTarget) {
      const Eigen::Vector2d way = command.odom_from_target.position() - pose.position();
      const double length = std::max(way.norm(), 1e-6);
      const Eigen::Vector2d moved = pose.position() + way * std::min(1.0, 0.03 / length);
      pose = {moved.x(), moved.y(), std::atan2(way.y(), way.x())};
    }
    least = std::min(least, world.clearance(pose.position()));
    if (distance(pose, goal) < 0.1) return least;
  }
  return std::nullopt;
}

TEST(LidarPlannerAndAvoidance, DriveThroughASixtyCentimetreDoor) {
  const FlatWorld world =
      FlatWorld().box(-1.0, -2.0, 5.0, 2.0).box(2.0, -2.0, 2.2, 0.5).box(2.0, 1.1, 2.2, 2.0);
  const std::optional<double> least = driveTo(world, {4.0, -1.0, 0.0}, 40.0);
  ASSERT_TRUE(least);
  EXPECT_GT(*least, kBody.circumradius_m);
}

TEST(LidarPlannerAndAvoidance, DriveThroughAZigzagPassage) {
  // Two walls 0.7 m apart with their openings at opposite ends.
  const FlatWorld world =
      FlatWorld().box(-1.0, -1.5, 4.0, 1.5).box(1.5, -1.5, 1.6, 0.8).box(2.3, -0.8, 2.4, 1.5);
  const std::optional<double> least = driveTo(world, {3.4, 0.0, 0.0}, 60.0);
  ASSERT_TRUE(least);
  // Past the corners of the walls it may come as near as the line of sight, less half a cell.
  EXPECT_GT(*least, kBody.half_width_m + 0.055);
}

TEST(LidarPlannerAndAvoidance, LeaveADeadEnd) {
  const FlatWorld world = FlatWorld()
                              .box(-2.0, -3.0, 6.0, 3.0)
                              .wall(0.0, -0.6, 2.0, -0.6)
                              .wall(0.0, 0.6, 2.0, 0.6)
                              .wall(2.0, -0.6, 2.0, 0.6);
  const std::optional<double> least = driveTo(world, {4.0, 0.0, 0.0}, 60.0);
  ASSERT_TRUE(least);
  EXPECT_GT(*least, kBody.circumradius_m);
}

}  // namespace
}  // namespace frugal_nav
