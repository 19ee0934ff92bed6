#include "flat_world.hpp"

#include <gtest/gtest.h>

#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/planning/sector_avoidance.hpp>

namespace frugal_nav {
namespace {

using planning_test::FlatWorld;
using planning_test::kBody;
using Status = MotionCommand::Status;

constexpr double kDeg = M_PI / 180.0;

/// A scan of nothing but returns at (bearing, range), one beam a degree.
LaserScan scanOf(const std::vector<std::pair<int, double>>& returns_deg_m, double stamp_s = 0.0) {
  LaserScan scan = FlatWorld().scan({}, stamp_s);
  for (const auto& [bearing_deg, range] : returns_deg_m) {
    scan.ranges_m[static_cast<std::size_t>(bearing_deg + 180)] = static_cast<float>(range);
  }
  return scan;
}

class SectorAvoidanceTest : public testing::Test {
 protected:
  MotionCommand planFor(const LaserScan& scan, const Eigen::Vector2d& target, const Pose2& pose = {}) {
    const std::vector<Eigen::Vector2d> obstacles = obstaclePoints(scan, {});
    Odometry odometry;
    odometry.stamp = scan.stamp;
    odometry.odom_from_base = pose;
    return sectors.plan({scan, {}, obstacles, odometry, target, target});
  }
  double chosenDeg() const { return sectors.decision().bearing_rad / kDeg; }

  SectorParams params;
  SectorAvoidance sectors{params, kBody};
};

TEST_F(SectorAvoidanceTest, GoesHalfAMetreTowardAFreeGoal) {
  const MotionCommand command = planFor(scanOf({}, 2.0), {3.0, 4.0});
  EXPECT_EQ(command.status, Status::kDriving);
  EXPECT_EQ(command.holds, MotionCommand::Holds::kTarget);
  EXPECT_EQ(command.stamp, stampFromSeconds(2.0));
  EXPECT_NEAR(command.odom_from_target.x_m, 0.3, 1e-9);
  EXPECT_NEAR(command.odom_from_target.y_m, 0.4, 1e-9);
}

TEST_F(SectorAvoidanceTest, GoesNoFartherThanTheGoal) {
  const MotionCommand command = planFor(scanOf({}), {0.2, 0.0});
  EXPECT_NEAR(command.odom_from_target.x_m, 0.2, 1e-9);
}

TEST_F(SectorAvoidanceTest, ReturnBlocksTwentyFiveDegreesToEachSide) {
  // Sector 0 is blocked, and 5 sectors to each side: the nearest free ones are at +-30 degrees.
  const LaserScan scan = scanOf({{0, 0.95}, {2, 0.95}});  // both of the same sector
  planFor(scan, {3.0, 0.3});                              // a little left: 5.7 degrees
  const SectorRing& ring = sectors.decision().ring;
  EXPECT_EQ(sectors.decision().narrowing, 0);
  for (int i = -5; i <= 5; ++i) EXPECT_FALSE(ring.isFree((i + 72) % 72)) << i;
  EXPECT_TRUE(ring.isFree(6));
  EXPECT_TRUE(ring.isFree(66));
  EXPECT_NEAR(chosenDeg(), 30.0, 1e-9);
}

TEST_F(SectorAvoidanceTest, ReturnsBeyondAMetreDoNotBlock) {
  planFor(scanOf({{0, 1.01}}), {3.0, 0.0});
  EXPECT_NEAR(chosenDeg(), 0.0, 1e-9);
}

TEST_F(SectorAvoidanceTest, NearReturnBlocksAtLeastWhatTheBodyNeeds) {
  // asin((0.125 + 0.04) / 0.25) = 41.3 degrees: sectors up to +-40 are blocked.
  planFor(scanOf({{0, 0.25}}), {3.0, 0.3});
  EXPECT_NEAR(chosenDeg(), 45.0, 1e-9);
}

TEST_F(SectorAvoidanceTest, ChoosesTheFreeSectorNearestToTheGoalDirection) {
  // Goal at 12 degrees. Blocked: -25..25 by the return ahead; to the left also 30..55 by the one at 55-25.
  planFor(scanOf({{0, 0.9}, {35, 0.9}}), {3.0, 3.0 * std::tan(12.0 * kDeg)});
  // Left: 35+25 = 60 blocked, so 65 (53 away); right: -30 (42 away).
  EXPECT_NEAR(chosenDeg(), -30.0, 1e-9);
}

TEST_F(SectorAvoidanceTest, IgnoresReturnsBeyondTheGoal) {
  // A wall 0.7 m ahead: in the way of a far goal, not of one in front of it.
  const LaserScan wall = FlatWorld().wall(0.7, -2.0, 0.7, 2.0).scan({});
  planFor(wall, {3.0, 0.0});
  EXPECT_GT(std::abs(chosenDeg()), 15.0);
  const MotionCommand command = planFor(wall, {0.45, 0.0});
  EXPECT_EQ(command.status, Status::kDriving);
  EXPECT_NEAR(command.odom_from_target.x_m, 0.45, 1e-9);
  EXPECT_NEAR(command.odom_from_target.y_m, 0.0, 1e-9);
  for (int i = 0; i < 72; ++i) EXPECT_TRUE(sectors.decision().ring.isFree(i)) << i;
}

TEST_F(SectorAvoidanceTest, GoesStraightToAGoalNearerThanTheObstaclesThere) {
  // Table legs on both sides block every sector ahead for the paper's rule, but not the way to the goal.
  const LaserScan legs = FlatWorld().box(0.6, 0.28, 0.65, 0.33).box(0.6, -0.33, 0.65, -0.28).scan({});
  const MotionCommand command = planFor(legs, {0.8, 0.0});
  EXPECT_EQ(command.status, Status::kDriving);
  EXPECT_NEAR(command.odom_from_target.x_m, 0.5, 1e-9);
  EXPECT_NEAR(command.odom_from_target.y_m, 0.0, 1e-9);
}

TEST_F(SectorAvoidanceTest, TieGoesToThePreviousDirection) {
  const LaserScan ahead = scanOf({{0, 0.9}});
  planFor(scanOf({}), {3.0, -3.0});  // first to the right: previous is -45 degrees
  planFor(ahead, {3.0, 0.0});
  EXPECT_NEAR(chosenDeg(), -30.0, 1e-9);
  sectors.reset();
  planFor(scanOf({}), {3.0, 3.0});
  planFor(ahead, {3.0, 0.0});
  EXPECT_NEAR(chosenDeg(), 30.0, 1e-9);
  // Slightly nearer on the other side is still a tie; by more than a sector it is not.
  planFor(ahead, {3.0, -3.0 * std::tan(2.0 * kDeg)});
  EXPECT_NEAR(chosenDeg(), 30.0, 1e-9);
  planFor(ahead, {3.0, -3.0 * std::tan(4.0 * kDeg)});
  EXPECT_NEAR(chosenDeg(), -30.0, 1e-9);
}

TEST_F(SectorAvoidanceTest, ThePreviousDirectionStaysInTheWorld) {
  planFor(scanOf({}), {3.0, 3.0 * std::tan(10.0 * kDeg)});  // 10 degrees to the left in odom
  // Turned left by 40 degrees, that direction lies 30 degrees to the right.
  const Pose2 turned{0.0, 0.0, 40.0 * kDeg};
  planFor(scanOf({{0, 0.9}}), turned * Eigen::Vector2d(3.0, 0.0), turned);
  EXPECT_NEAR(chosenDeg(), -30.0, 1e-9);
}

TEST_F(SectorAvoidanceTest, UnknownIsNotFree) {
  LaserScan scan = scanOf({});
  for (int bearing = -12; bearing <= 12; ++bearing) {
    scan.ranges_m[static_cast<std::size_t>(bearing + 180)] = std::numeric_limits<float>::quiet_NaN();
  }
  planFor(scan, {3.0, 0.0});
  EXPECT_NEAR(std::abs(chosenDeg()), 15.0, 1e-9);
  // A single lost beam hides nothing.
  LaserScan lost = scanOf({});
  lost.ranges_m[180] = std::numeric_limits<float>::quiet_NaN();
  planFor(lost, {3.0, 0.0});
  EXPECT_NEAR(chosenDeg(), 0.0, 1e-9);
}

TEST_F(SectorAvoidanceTest, DrivesAlongANarrowPassage) {
  for (const double width : {0.60, 0.65, 0.70}) {
    // The walls block every sector ahead by the paper's rule; the body fits with 17 cm to each side.
    const FlatWorld passage =
        FlatWorld().wall(-3, width / 2, 3, width / 2).wall(-3, -width / 2, 3, -width / 2);
    for (const double offset : {-0.05, 0.0, 0.05}) {
      for (const double yaw_deg : {-8.0, 0.0, 8.0}) {
        const Pose2 pose{0.0, offset, yaw_deg * kDeg};
        const MotionCommand command = planFor(passage.scan(pose), {0.8, 0.0}, pose);
        ASSERT_EQ(command.status, Status::kDriving) << width << ' ' << offset << ' ' << yaw_deg;
        EXPECT_GT(command.odom_from_target.x_m, 0.2);
        EXPECT_LT(std::abs(command.odom_from_target.y_m), width / 2 - 0.165);
        sectors.reset();
      }
    }
  }
}

TEST_F(SectorAvoidanceTest, NarrowsOnlyAsFarAsNeeded) {
  const auto narrowing = [this](double width) {
    // The goal is far, so that only the sectors decide.
    FlatWorld passage = FlatWorld().wall(-9, width / 2, 9, width / 2).wall(-9, -width / 2, 9, -width / 2);
    planFor(passage.box(5, -width / 2, 5.1, width / 2).scan({}), {8.0, 0.0});
    return sectors.decision().narrowing;
  };
  EXPECT_EQ(narrowing(1.6), 0);
  EXPECT_EQ(narrowing(0.6), 1);
  EXPECT_GT(narrowing(0.42), 1);
}

TEST_F(SectorAvoidanceTest, PrefersANarrowWayOnToAWideWayBack) {
  // At the mouth of a passage of 0.6 m, with free space behind; its end hides the goal.
  const FlatWorld mouth =
      FlatWorld().box(0.2, 0.3, 5.0, 2.0).box(0.2, -2.0, 5.0, -0.3).wall(5.0, -0.3, 5.0, 0.3);
  planFor(mouth.scan({}), {8.0, 0.0});
  EXPECT_NEAR(chosenDeg(), 0.0, 1e-9);
  // The paper's rule alone turns away.
  params.max_detour_rad = 3.1416;
  sectors = SectorAvoidance(params, kBody);
  planFor(mouth.scan({}), {8.0, 0.0});
  EXPECT_GT(std::abs(chosenDeg()), 90.0);
}

TEST_F(SectorAvoidanceTest, ReportsBlockedWhenTheBodyDoesNotFit) {
  // Turning on the spot is possible, leaving is not; the clearer side is ahead already.
  const LaserScan pen = FlatWorld().box(-0.22, -0.22, 0.33, 0.22).scan({});
  const MotionCommand command = planFor(pen, {3.0, 0.0});
  EXPECT_EQ(command.status, Status::kBlocked);
  EXPECT_EQ(command.holds, MotionCommand::Holds::kNothing);
  EXPECT_FALSE(command.reason.empty());
}

TEST_F(SectorAvoidanceTest, TurnsTowardTheLargerClearanceAndThenReportsBlocked) {
  // Pen around the robot, its corner at the left behind the farthest.
  const FlatWorld pen = FlatWorld().box(-0.38, -0.26, 0.26, 0.38);
  SectorParams wide = params;
  wide.last_margin_m = wide.first_margin_m = 0.20;  // a body that does not fit out
  sectors = SectorAvoidance(wide, kBody);
  const MotionCommand first = planFor(pen.scan({}, 0.0), {3.0, 0.0});
  ASSERT_EQ(first.status, Status::kTurning);
  EXPECT_EQ(first.holds, MotionCommand::Holds::kVelocity);
  EXPECT_EQ(first.velocity.v_mps, 0.0);
  EXPECT_NEAR(first.velocity.w_radps, params.turn_rate_radps, 1e-9);
  EXPECT_GT(first.clear_bearing_rad, 90.0 * kDeg);
  EXPECT_EQ(planFor(pen.scan({}, params.turn_time_s + 0.1), {3.0, 0.0}).status, Status::kBlocked);
}

TEST_F(SectorAvoidanceTest, DoesNotTurnWhereTheTailWouldTouch) {
  const FlatWorld pen = FlatWorld().box(-0.9, -0.205, 0.205, 0.205);
  SectorParams wide = params;
  wide.last_margin_m = wide.first_margin_m = 0.20;
  sectors = SectorAvoidance(wide, kBody);
  EXPECT_EQ(planFor(pen.scan({}), {3.0, 0.0}).status, Status::kBlocked);
}

TEST_F(SectorAvoidanceTest, PointsToTheClearSide) {
  const FlatWorld world = FlatWorld().wall(0.5, -3.0, 0.5, 3.0).wall(-3.0, -0.5, 0.5, -0.5);
  const MotionCommand command = planFor(world.scan({}), {3.0, 0.0});
  // Clear for 4 m with 25 degrees to spare, nearest to the wanted direction.
  EXPECT_GT(command.clear_bearing_rad, 100.0 * kDeg);
  EXPECT_LT(command.clear_bearing_rad, 150.0 * kDeg);
}

TEST(SectorParams, NamesContradictions) {
  SectorParams params;
  params.last_margin_m = 0.5;
  EXPECT_THROW(SectorAvoidance(params, kBody), ConfigError);
  EXPECT_THROW(SectorAvoidance(SectorParams{}, BodyExtent{}), ConfigError);
}

TEST(SectorRing, BearingsBelongToTheNearestCentre) {
  const SectorRing ring(72);
  EXPECT_EQ(ring.sectorOf(2.4 * kDeg), 0);
  EXPECT_EQ(ring.sectorOf(-2.4 * kDeg), 0);
  EXPECT_EQ(ring.sectorOf(2.6 * kDeg), 1);
  EXPECT_EQ(ring.sectorOf(-2.6 * kDeg), 71);
  EXPECT_EQ(ring.sectorOf(M_PI), 36);
  EXPECT_EQ(ring.sectorOf(-M_PI), 36);
  for (int i = 0; i < 72; ++i) EXPECT_EQ(ring.sectorOf(ring.bearingOf(i)), i);
}

TEST(SectorRing, SparseBeamsSpeakForTheDirectionsBetweenThem) {
  LaserScan scan;  // 24 beams, 15 degrees apart
  scan.angle_increment_rad = 15.0 * kDeg;
  scan.range_min_m = 0.1;
  scan.range_max_m = 5.0;
  scan.ranges_m.assign(24, 4.0F);
  const SectorRing ring(72);
  const std::vector<bool> observed = observedSectors(ring, scan, {});
  EXPECT_EQ(std::count(observed.begin(), observed.end(), true), 72);
}

}  // namespace
}  // namespace frugal_nav
