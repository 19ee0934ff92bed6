#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/control/blind_watch.hpp>
#include <frugal_nav/control/collision_guard.hpp>

namespace frugal_nav {
namespace {

using Points = std::vector<Eigen::Vector2d>;

/// frugal_bot's outline, roughly: 0.28 m x 0.25 m, the wheels' axis a little before its middle.
const Polygon2 kFootprint{{0.12, -0.125}, {0.12, 0.125}, {-0.16, 0.125}, {-0.16, -0.125}};

Points wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  Points points;
  for (int i = 0; i <= 100; ++i) points.push_back(from + (to - from) * i / 100.0);
  return points;
}

/// Drives a command through the guard, in a world that a scan of age zero shows in each cycle; the base has
/// the guard's reaction time and brakes as it assumes: speed and turn each by its own deceleration. The
/// smallest clearance on the way.
double drivenClearance(const CollisionGuard& guard, const Twist2& command, const Points& world, Pose2& pose) {
  constexpr double kCycle_s = 0.05;
  const CollisionGuardParams params;
  const auto reached = [&](const Twist2& from, const Twist2& to) {
    const double slower_mps = std::abs(from.v_mps) - params.brake_mps2 * kCycle_s;
    const double turn_radps = params.turn_brake_radps2 * kCycle_s;
    const bool brakes = slower_mps > 0.0 && to.v_mps * from.v_mps < slower_mps * std::abs(from.v_mps);
    return Twist2{brakes ? std::copysign(slower_mps, from.v_mps) : to.v_mps,
                  from.w_radps + std::clamp(to.w_radps - from.w_radps, -turn_radps, turn_radps)};
  };
  double smallest = std::numeric_limits<double>::infinity();
  Twist2 present;
  for (int i = 0; i < 500; ++i) {
    Points p_base;
    for (const auto& p : world) p_base.push_back(pose.inverse() * p);
    for (const auto& p : p_base) smallest = std::min(smallest, guard.clearance(p));
    const Twist2 next = reached(present, guard.check(command, present, 0.0, p_base).velocity);
    pose = pose * arcMotion(present, 0.04) * arcMotion(next, kCycle_s - 0.04);
    present = next;
  }
  return smallest;
}

TEST(CollisionGuard, LeavesAFreeWayAlone) {
  const CollisionGuard guard({}, kFootprint);
  const GuardedTwist guarded = guard.check({0.3, 0.5}, {0.3, 0.5}, 0.1, wall({2.0, -1.0}, {2.0, 1.0}));
  EXPECT_EQ(guarded.share, 1.0);
  EXPECT_EQ(guarded.velocity, (Twist2{0.3, 0.5}));
}

TEST(CollisionGuard, StopsBeforeAWall) {
  const CollisionGuard guard({}, kFootprint);
  for (const double speed : {0.1, 0.35, 1.0, 2.0}) {
    Pose2 pose;
    const double clearance = drivenClearance(guard, {speed, 0.0}, wall({2.0, -1.0}, {2.0, 1.0}), pose);
    EXPECT_GT(clearance, 0.005) << speed;
    // The margin, and what a cycle of 0.05 s at the smallest share but one leaves of the way.
    EXPECT_LT(clearance, 0.04 + 0.05 * speed) << "stopped much too early at " << speed;
  }
}

TEST(CollisionGuard, StopsBeforeAThinPole) {
  const CollisionGuard guard({}, kFootprint);
  for (const double y : {0.0, 0.1, -0.13}) {
    Pose2 pose;
    EXPECT_GT(drivenClearance(guard, {0.5, 0.0}, {{1.0, y}}, pose), 0.005) << y;
  }
}

TEST(CollisionGuard, ArcsAndTurnsKeepClearOfEverything) {
  const CollisionGuard guard({}, kFootprint);
  Random random(500002);
  for (int trial = 0; trial < 200; ++trial) {
    Points world;
    while (world.size() < 30) {
      const Eigen::Vector2d p(random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8));
      if (guard.clearance(p) > 0.03) world.push_back(p);
    }
    Pose2 pose;
    const Twist2 command{random.uniform(-0.3, 0.5), random.uniform(-2.0, 2.0)};
    EXPECT_GT(drivenClearance(guard, command, world, pose), 0.0)
        << "trial " << trial << ", v " << command.v_mps << ", w " << command.w_radps;
  }
}

TEST(CollisionGuard, ATurnThatSweepsAnObstacleIsStopped) {
  const CollisionGuard guard({}, kFootprint);
  const Points pole{{0.08, 0.156}};  // 3.1 cm to the left: the front left corner sweeps there in a left turn
  EXPECT_GT(guard.clearance(pole[0]), 0.025);
  EXPECT_LT(guard.check({0.0, 1.0}, {}, 0.1, pole).share, 1.0);
  EXPECT_EQ(guard.check({0.0, -1.0}, {}, 0.1, pole).share, 1.0);
}

TEST(CollisionGuard, AllowsMotionAwayFromATouchingWall) {
  const CollisionGuard guard({}, kFootprint);
  const Points touching = wall({0.13, -1.0}, {0.13, 1.0});  // 1 cm before the front
  EXPECT_EQ(guard.check({0.2, 0.0}, {}, 0.1, touching).share, 0.0);
  EXPECT_EQ(guard.check({0.2, 0.3}, {}, 0.1, touching).share, 0.0);
  EXPECT_EQ(guard.check({-0.1, 0.0}, {}, 0.1, touching).velocity, (Twist2{-0.1, 0.0}));
}

TEST(CollisionGuard, CountsTheWayThePresentVelocityStillGoes) {
  const CollisionGuard guard({}, kFootprint);
  const Points ahead = wall({0.12 + 0.07, -1.0}, {0.12 + 0.07, 1.0});
  EXPECT_EQ(guard.check({0.05, 0.0}, {0.05, 0.0}, 0.0, ahead).share, 1.0);
  EXPECT_EQ(guard.check({0.05, 0.0}, {0.60, 0.0}, 0.0, ahead).share, 0.0);  // 6 cm before the motors react
}

TEST(CollisionGuard, ASlowerCommandIsReachedByBraking) {
  CollisionGuardParams params;
  params.brake_mps2 = 4.0;
  const CollisionGuard guard(params, kFootprint);
  // From 2 m/s it goes 0.2 m before the motors react and 0.5 m more however slow the command is.
  EXPECT_EQ(guard.check({2.0, 0.0}, {2.0, 0.0}, 0.0, {{0.12 + 0.6, 0.0}}).share, 0.0);
  EXPECT_GT(guard.check({2.0, 0.0}, {2.0, 0.0}, 0.0, {{0.12 + 0.9, 0.0}}).share, 0.0);
}

TEST(CollisionGuard, KnowsTheWayOutOfTheFootprint) {
  const CollisionGuard guard({}, kFootprint);
  EXPECT_NEAR(guard.wayOut_m({0.02, 0.0}, {1.0, 0.0}), 0.10, 1e-12);
  EXPECT_NEAR(guard.wayOut_m({0.02, 0.0}, {0.0, -1.0}), 0.125, 1e-12);
  EXPECT_EQ(guard.wayOut_m({0.2, 0.0}, {1.0, 0.0}), 0.0) << "a laser before the body";
}

TEST(CollisionGuard, AnOldScanMakesItMoreCareful) {
  const CollisionGuard guard({}, kFootprint);
  const Points near = wall({0.12 + 0.15, -1.0}, {0.12 + 0.15, 1.0});
  EXPECT_EQ(guard.check({0.35, 0.0}, {0.35, 0.0}, 0.0, near).share, 1.0);
  EXPECT_LT(guard.check({0.35, 0.0}, {0.35, 0.0}, 0.4, near).share, 1.0);
}

TEST(CollisionGuard, PassesADoorwayALittleWiderThanItself) {
  const CollisionGuard guard({}, kFootprint);
  Points door = wall({1.0, 0.16}, {1.0, 2.0});  // 0.32 m wide for a robot of 0.25 m: 3.5 cm on either side
  const Points other = wall({1.0, -0.16}, {1.0, -2.0});
  door.insert(door.end(), other.begin(), other.end());
  Pose2 pose;
  EXPECT_GT(drivenClearance(guard, {0.35, 0.0}, door, pose), 0.03);
  EXPECT_GT(pose.x_m, 1.5);
}

/// A door in a wall of 0.1 m thickness, seen on its jambs too.
Points door(double width_m) {
  Points points;
  for (const double side : {1.0, -1.0}) {
    const double y = side * 0.5 * width_m;
    for (const Points& part : {wall({1.0, y}, {1.0, side * 2.0}), wall({1.0, y}, {1.1, y})})
      points.insert(points.end(), part.begin(), part.end());
  }
  return points;
}

TEST(CollisionGuard, DrivesSlowlyThroughADoorFourCentimetresWiderThanItself) {
  const CollisionGuard guard({}, kFootprint);
  Pose2 pose;
  EXPECT_GT(drivenClearance(guard, {0.08, 0.0}, door(0.29), pose), 0.009);
  EXPECT_GT(pose.x_m, 1.5);
  Pose2 fast;
  drivenClearance(guard, {0.35, 0.0}, door(0.26), fast);
  EXPECT_LT(fast.x_m, 1.0) << "half a centimetre on either side is too little";
}

TEST(CollisionGuard, ASlowTurnOnTheSpotKeepsTheWholeMargin) {
  const CollisionGuard guard({}, kFootprint);
  Pose2 pose;  // a corner, 0.173 m from the axis, sweeps toward the point, 0.168 m from it
  EXPECT_GT(drivenClearance(guard, {0.0, 0.15}, {{0.05, 0.16}}, pose), 0.02);
}

TEST(CollisionGuard, BendsASlowWayThatScrapesAJamb) {
  const CollisionGuard guard({}, kFootprint);
  Pose2 pose{0.90, 0.0, 0.05};  // askew in the door: straight on its left front would scrape
  EXPECT_GT(drivenClearance(guard, {0.06, 0.0}, door(0.29), pose), 0.0);
  EXPECT_GT(pose.x_m, 1.4);
}

TEST(CollisionGuard, FreeDistanceIsThatToTheMargin) {
  const CollisionGuard guard({}, kFootprint);
  const Points ahead = wall({0.5, -1.0}, {0.5, 1.0});
  EXPECT_NEAR(guard.freeDistance({0.3, 0.0}, 1.0, ahead), 0.5 - 0.12 - 0.025, 0.016);  // one step of 1.5 cm
  EXPECT_EQ(guard.freeDistance({-0.3, 0.0}, 1.0, ahead), 1.0);
  EXPECT_EQ(guard.freeDistance({0.0, 1.0}, 1.0, ahead), 1.0);
}

TEST(CollisionGuard, RefusesAFootprintThatIsNotConvex) {
  EXPECT_THROW(CollisionGuard({}, {{1.0, 0.0}, {0.0, 1.0}}), ConfigError);
  EXPECT_THROW(CollisionGuard({}, {{1.0, 1.0}, {1.0, -1.0}, {-1.0, -1.0}, {-1.0, 1.0}}), ConfigError)
      << "clockwise";
  EXPECT_THROW(CollisionGuard({}, {{1.0, -1.0}, {1.0, 1.0}, {0.0, 0.0}, {-1.0, 1.0}, {-1.0, -1.0}}),
               ConfigError);
}

LaserScan scanOf(float range) {
  LaserScan scan;
  scan.angle_min_rad = -M_PI;
  scan.angle_increment_rad = 2.0 * M_PI / 360.0;
  scan.range_min_m = 0.15;
  scan.range_max_m = 12.0;
  scan.ranges_m.assign(360, range);
  return scan;
}

TEST(BlindWatch, ThreeScansWithoutAnythingAheadAreBlind) {
  BlindWatch watch;
  LaserScan scan = scanOf(3.0F);
  for (std::size_t i = 150; i < 210; ++i)
    scan.ranges_m[i] = std::nanf("");  // 30 degrees to either side ahead
  watch.add(scan, {});
  watch.add(scan, {});
  EXPECT_FALSE(watch.isBlindAhead());
  watch.add(scan, {});
  EXPECT_TRUE(watch.isBlindAhead());
  EXPECT_FALSE(watch.isBlindBehind());
  watch.add(scanOf(std::numeric_limits<float>::infinity()), {});
  EXPECT_FALSE(watch.isBlindAhead()) << "free is not blind";
}

TEST(BlindWatch, ALaserThatLooksAheadOnlyIsBlindBehind) {
  BlindWatch watch;
  LaserScan scan = scanOf(2.0F);
  scan.angle_min_rad = -M_PI / 2.0;
  scan.ranges_m.resize(180);
  for (int i = 0; i < 3; ++i) watch.add(scan, {});
  EXPECT_FALSE(watch.isBlindAhead());
  EXPECT_TRUE(watch.isBlindBehind());
}

}  // namespace
}  // namespace frugal_nav
