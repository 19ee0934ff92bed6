#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <support/camera_course.hpp>

#include <frugal_nav/planning/obstacle_memory.hpp>

namespace frugal_nav {
namespace {

using Vec = Eigen::Vector2d;
using State = RollingGrid::State;

constexpr std::size_t kBeams = 63;

/// A scan of 62 degrees whose beams all see `range`.
LaserScan evenScan(double time_s, double range) {
  LaserScan scan;
  scan.stamp = stampFromSeconds(time_s);
  scan.angle_min_rad = -31.0 / 180.0 * M_PI;
  scan.angle_increment_rad = M_PI / 180.0;
  scan.range_min_m = 0.05;
  scan.range_max_m = 6.0;
  scan.ranges_m.assign(kBeams, static_cast<float>(range));
  return scan;
}

constexpr double kNothing = std::numeric_limits<double>::infinity();

/// The same with an object as wide as `half_width` to each side of a place in the scan's frame.
LaserScan withObject(LaserScan scan, const Vec& p, double half_width) {
  const double range = p.norm();
  const double half_angle = std::atan2(half_width, range);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (std::abs(scan.angleOf(i) - std::atan2(p.y(), p.x())) <= half_angle)
      scan.ranges_m[i] = static_cast<float>(range);
  }
  return scan;
}

NearestObstacle nothingNear() { return {}; }

State stateAt(const ObstacleMemory& memory, double x, double y) {
  return memory.grid().state(memory.grid().cellOf({x, y}));
}

TEST(ObstacleMemory, WhatIsTooNearToBeSeenIsNotTakenAwayByRays) {
  ObstacleMemory memory(ObstacleMemoryParams{});
  for (int i = 0; i < 8; ++i)  // often enough to be certain
    memory.insert(withObject(evenScan(1.0 + 0.1 * i, kNothing), {2.02, 0.0}, 0.2), nothingNear(), {},
                  std::nullopt);
  ASSERT_EQ(stateAt(memory, 2.01, 0.01), State::kOccupied);
  // From 0.8 m its foot is below the image, and the depth says whatever it likes.
  const Pose2 near{1.2, 0.0, 0.0};
  for (int i = 0; i < 30; ++i)
    memory.insert(evenScan(2.0 + 0.1 * i, kNothing), nothingNear(), near, std::nullopt);
  EXPECT_EQ(stateAt(memory, 2.01, 0.01), State::kOccupied);
  EXPECT_EQ(stateAt(memory, 1.6, 0.01), State::kFree);
  // From 1.7 m it could be seen.
  const Pose2 far{0.3, 0.0, 0.0};
  for (int i = 0; i < 30; ++i)
    memory.insert(evenScan(6.0 + 0.1 * i, kNothing), nothingNear(), far, std::nullopt);
  EXPECT_EQ(stateAt(memory, 2.01, 0.01), State::kFree);
}

TEST(ObstacleMemory, RemembersWhatLeavesTheViewAndForgetsIt) {
  ObstacleMemory memory(ObstacleMemoryParams{});
  memory.insert(withObject(evenScan(1.0, kNothing), {2.02, 0.0}, 0.2), nothingNear(), {}, std::nullopt);
  EXPECT_EQ(stateAt(memory, 2.01, 0.01), State::kOccupied);
  EXPECT_EQ(stateAt(memory, 1.0, 0.01), State::kFree);
  EXPECT_EQ(stateAt(memory, 0.5, 1.0), State::kUnknown);  // beside the robot it is blind
  const Pose2 turned{0.0, 0.0, 1.5};
  memory.insert(evenScan(20.0, kNothing), nothingNear(), turned, std::nullopt);
  EXPECT_EQ(stateAt(memory, 2.01, 0.01), State::kOccupied);
  memory.insert(evenScan(31.5, kNothing), nothingNear(), turned, std::nullopt);  // 30 s
  EXPECT_EQ(stateAt(memory, 2.01, 0.01), State::kUnknown);
}

TEST(ObstacleMemory, ClearsWhatIsSeenFree) {
  ObstacleMemory memory(ObstacleMemoryParams{});
  memory.insert(withObject(evenScan(1.0, kNothing), {2.02, 0.0}, 0.2), nothingNear(), {}, std::nullopt);
  for (int i = 1; i <= 4; ++i)
    memory.insert(evenScan(1.0 + 0.2 * i, kNothing), nothingNear(), {}, std::nullopt);
  EXPECT_EQ(stateAt(memory, 2.01, 0.01), State::kFree);
}

TEST(ObstacleMemory, WhereTheFloorIsBelowTheViewRaysTakeAwayTheDoubtfulOnly) {
  ObstacleMemory memory(ObstacleMemoryParams{});
  auto see = [&memory, time_s = 1.0](int times, const LaserScan& scan) mutable {
    for (int i = 0; i < times; ++i) {
      LaserScan now = scan;
      now.stamp = stampFromSeconds(time_s += 0.2);
      memory.insert(now, nothingNear(), {}, std::nullopt);
    }
  };
  see(8, withObject(evenScan(0.0, kNothing), {1.02, 0.0}, 0.1));
  see(2, withObject(evenScan(0.0, kNothing), {0.92, 0.42}, 0.05));
  see(1, withObject(evenScan(0.0, kNothing), {0.62, -0.32}, 0.05));
  ASSERT_EQ(stateAt(memory, 0.92, 0.42), State::kOccupied);
  see(20, evenScan(0.0, kNothing));
  EXPECT_EQ(stateAt(memory, 1.03, 0.01), State::kOccupied);   // it is low and has left the image below
  EXPECT_EQ(stateAt(memory, 0.92, 0.42), State::kFree);       // this was seen twice only
  EXPECT_EQ(stateAt(memory, 0.62, -0.32), State::kOccupied);  // nearer, much is below the image
  EXPECT_EQ(stateAt(memory, 0.5, 0.01), State::kFree);        // and what was never seen counts as free
}

TEST(ObstacleMemory, AGuessFromNearbyDoesNotMoveWhatWasSeenWell) {
  ObstacleMemory memory(ObstacleMemoryParams{});
  memory.insert(withObject(evenScan(1.0, kNothing), {2.02, 0.0}, 0.2), nothingNear(), {}, std::nullopt);
  const Pose2 near{1.2, 0.0, 0.0};  // 0.8 m before it: the depth says 0.65 m
  memory.insert(withObject(evenScan(2.0, kNothing), {0.65, 0.0}, 0.2), nothingNear(), near, std::nullopt);
  EXPECT_EQ(stateAt(memory, 2.01, 0.01), State::kOccupied);
  EXPECT_EQ(stateAt(memory, 1.86, 0.01), State::kFree);
  // A leg that steps in between is none of it.
  memory.insert(withObject(evenScan(3.0, kNothing), {0.17, 0.0}, 0.1), nothingNear(), near, std::nullopt);
  EXPECT_EQ(stateAt(memory, 1.38, 0.01), State::kOccupied);
}

TEST(ObstacleMemory, WhatStoodForLongIsNotWipedOutByWhatSeemsToMove) {
  ObstacleMemory memory(ObstacleMemoryParams{});
  const LaserScan scan = withObject(evenScan(1.0, kNothing), {2.02, 0.0}, 0.2);
  LaserScan now = scan;
  for (int i = 0; i < 10; ++i, now.stamp += fromSeconds(0.2))
    memory.insert(now, nothingNear(), {}, std::nullopt);
  NearestObstacle moving;
  moving.found = true;
  moving.p_odom = {2.02, 0.0};
  moving.velocity_mps = {0.0, 0.6};
  for (int i = 0; i < 3; ++i, now.stamp += fromSeconds(0.2))
    memory.insert(evenScan(toSeconds(now.stamp - Stamp{}), kNothing), moving, {}, std::nullopt);
  EXPECT_TRUE(memory.moving().empty());
  EXPECT_EQ(stateAt(memory, 2.01, 0.01), State::kOccupied);
}

TEST(ObstacleMemory, NeitherMarksNorClearsWhereTheScanKnowsNothing) {
  ObstacleMemory memory(ObstacleMemoryParams{});
  memory.insert(withObject(evenScan(1.0, kNothing), {2.02, 0.0}, 0.2), nothingNear(), {}, std::nullopt);
  for (int i = 1; i <= 10; ++i)
    memory.insert(evenScan(1.0 + 0.2 * i, std::nan("")), nothingNear(), {}, std::nullopt);
  EXPECT_EQ(stateAt(memory, 2.01, 0.01), State::kOccupied);
}

TEST(ObstacleMemory, DoesNotWearOffEdgesThatRaysGraze) {
  // Half the view is a box 1.02 m away; its edge is at a bearing of zero. Rays beside it see far.
  ObstacleMemory memory(ObstacleMemoryParams{});
  LaserScan scan = evenScan(1.0, kNothing);
  for (std::size_t i = 0; i <= kBeams / 2; ++i) scan.ranges_m[i] = 1.02F;
  memory.insert(scan, nothingNear(), {}, std::nullopt);
  ASSERT_EQ(stateAt(memory, 1.01, -0.01), State::kOccupied);
  // The edge moves by one beam, 0.017 m, to and fro; the cell stays.
  for (int n = 1; n <= 40; ++n) {
    scan.stamp = stampFromSeconds(1.0 + 0.2 * n);
    scan.ranges_m[kBeams / 2] = static_cast<float>(kNothing);
    memory.insert(scan, nothingNear(), {}, std::nullopt);
  }
  EXPECT_EQ(stateAt(memory, 1.01, -0.01), State::kOccupied);
}

TEST(ObstacleMemory, BlowsTheNearestObstacleUpByItsSigma) {
  ObstacleMemory memory(ObstacleMemoryParams{});
  NearestObstacle nearest;
  nearest.found = true;
  nearest.p_odom = {1.5, 0.0};
  nearest.sigma_m = 0.15;
  memory.insert(evenScan(1.0, std::nan("")), nearest, {}, std::nullopt);
  EXPECT_EQ(stateAt(memory, 1.5, 0.12), State::kOccupied);
  EXPECT_EQ(stateAt(memory, 1.39, 0.0), State::kOccupied);
  EXPECT_EQ(stateAt(memory, 1.5, 0.26), State::kUnknown);
}

TEST(ObstacleMemory, LeavesTheGoalPersonOut) {
  ObstacleMemory memory(ObstacleMemoryParams{});
  const LaserScan scan = withObject(evenScan(1.0, kNothing), {2.52, 0.0}, 0.25);
  memory.insert(scan, nothingNear(), {}, Vec(2.6, 0.1));
  EXPECT_EQ(stateAt(memory, 2.51, 0.01), State::kUnknown);
  EXPECT_EQ(stateAt(memory, 2.0, 0.01), State::kFree);  // but what lies before it is seen
  memory.insert(withObject(evenScan(1.2, kNothing), {1.42, 0.0}, 0.25), nothingNear(), {}, Vec(2.6, 0.1));
  EXPECT_EQ(stateAt(memory, 1.41, 0.01), State::kOccupied);  // another, before the person
}

/// Feeds a memory with someone who walks, and the wall 4 m away behind.
void walk(ObstacleMemory& memory, const Vec& from, const Vec& velocity, double seconds, double rate_hz,
          const Pose2& robot = {}) {
  for (double t = 0.0; t <= seconds; t += 1.0 / rate_hz) {
    const Vec p = robot.inverse() * (from + t * velocity);
    memory.insert(withObject(evenScan(1.0 + t, 4.0), p, 0.22), nothingNear(), robot, std::nullopt);
  }
}

TEST(ObstacleMemory, TellsWhoWalksAndLeavesNoTrail) {
  for (const double rate_hz : {5.0, 1.3}) {
    ObstacleMemory memory(ObstacleMemoryParams{});
    walk(memory, {2.0, -0.9}, {0.0, 0.6}, 2.4, rate_hz);
    ASSERT_EQ(memory.moving().size(), 1U) << rate_hz;
    const TrackedObstacle& walker = memory.moving().front();
    EXPECT_NEAR(walker.velocity_mps.y(), 0.6, 0.15);
    EXPECT_NEAR(walker.velocity_mps.x(), 0.0, 0.15);
    EXPECT_NEAR(walker.at(1.0).y(), walker.p_odom.y() + walker.velocity_mps.y(), 1e-12);
    // Only what lies beyond the grazing margin is asked: the wall behind is 4 m away.
    for (double y = -0.9; y < walker.p_odom.y() + 0.3; y += 0.05)
      EXPECT_NE(stateAt(memory, 2.01, y), State::kOccupied) << y << " at " << rate_hz << " Hz";
  }
}

TEST(ObstacleMemory, TakesNoStandingThingForAWalker) {
  // A robot drives past a post and a box, with the noise of a camera.
  Random random(500001);
  ObstacleMemory memory(ObstacleMemoryParams{});
  for (int n = 0; n < 60; ++n) {
    const Pose2 robot{0.05 * n, 0.0, 0.0};
    LaserScan scan = evenScan(1.0 + 0.2 * n, 6.0);
    scan = withObject(scan, robot.inverse() * Vec(4.0, 0.7), 0.1);
    scan = withObject(scan, robot.inverse() * Vec(4.5, -0.9), 0.35);
    const double scale = 1.0 + random.normal(0.03);
    for (float& range : scan.ranges_m) range = static_cast<float>(range * scale + random.normal(0.03));
    memory.insert(scan, nothingNear(), robot, std::nullopt);
    EXPECT_TRUE(memory.moving().empty()) << n;
  }
  EXPECT_EQ(stateAt(memory, 4.0, 0.7), State::kOccupied);
}

TEST(ObstacleMemory, WhoStopsBecomesAnObstacle) {
  ObstacleMemory memory(ObstacleMemoryParams{});
  walk(memory, {2.0, -0.9}, {0.0, 0.6}, 1.6, 5.0);
  ASSERT_EQ(memory.moving().size(), 1U);
  for (int n = 1; n <= 20; ++n) {
    memory.insert(withObject(evenScan(2.6 + 0.2 * n, 4.0), {2.02, 0.06}, 0.22), nothingNear(), {},
                  std::nullopt);
  }
  EXPECT_TRUE(memory.moving().empty());
  EXPECT_EQ(stateAt(memory, 2.01, 0.06), State::kOccupied);
}

TEST(ObstacleMemory, BelievesAVelocityThatComesWithTheNearestObstacle) {
  ObstacleMemory memory(ObstacleMemoryParams{});
  NearestObstacle nearest;
  nearest.found = true;
  nearest.p_odom = {1.5, 0.5};
  nearest.velocity_mps = {0.0, -0.8};
  nearest.sigma_m = 0.1;
  memory.insert(evenScan(1.0, kNothing), nearest, {}, std::nullopt);
  ASSERT_EQ(memory.moving().size(), 1U);
  EXPECT_NE(stateAt(memory, 1.5, 0.5), State::kOccupied);
}

TEST(ForegroundObjects, LeavesOutWhatIsCutOrHidden) {
  const ObstacleTrackerParams params;
  const LaserScan wall = evenScan(1.0, 4.0);
  EXPECT_TRUE(foregroundObjects(wall, params).empty());  // a wall across the view
  const LaserScan middle = withObject(wall, {2.02, 0.0}, 0.2);
  ASSERT_EQ(foregroundObjects(middle, params).size(), 1U);
  // Every beam stands for its whole angle: 12 beams of 1 degree at 2 m, 0.42 m.
  EXPECT_NEAR(foregroundObjects(middle, params)[0].width_m, 0.4, 0.04);
  EXPECT_NEAR(foregroundObjects(middle, params)[0].bearing_rad, 0.0, 0.01);
  const LaserScan cut = withObject(wall, {1.75, 1.0}, 0.2);  // 30 degrees: over the edge of the view
  EXPECT_TRUE(foregroundObjects(cut, params).empty());
  const LaserScan hidden = withObject(middle, {1.0, -0.1}, 0.1);
  const std::vector<ScanObject> objects = foregroundObjects(hidden, params);
  ASSERT_EQ(objects.size(), 1U);  // the nearer one alone: it hides part of the other
  EXPECT_NEAR(objects[0].range_m, 1.0, 0.02);
}

// A box 0.9 m wide comes into view within half a second: its visible middle walks 0.4 m, yet it never leaves
// the place it was seen first. A walker as fast does.
TEST(ObstacleTracker, TakesNoThingThatComesIntoViewForAWalker) {
  ObstacleTracker of_box(ObstacleTrackerParams{});
  ObstacleTracker of_walker(ObstacleTrackerParams{});
  const auto nothing = [](const Vec&) { return false; };
  for (int i = 0; i <= 10; ++i) {
    const LaserScan wall = evenScan(1.0 + 0.05 * i, 4.0);
    const double half_width = 0.05 + 0.04 * i;
    of_box.update(withObject(wall, {2.0, half_width}, half_width), {}, nothing);
    EXPECT_TRUE(of_box.moving().empty()) << i;
    of_walker.update(withObject(wall, {2.0, half_width}, 0.1), {}, nothing);
  }
  EXPECT_EQ(of_walker.moving().size(), 1U);
}

// In a cluttered room another thing stands out in each image: 0.3 m wide, within 1 m of the last.
TEST(ObstacleTracker, TakesNoClutterForAWalker) {
  Random random(500001);
  ObstacleTracker tracker(ObstacleTrackerParams{});
  for (int i = 0; i < 300; ++i) {
    const Vec p(random.uniform(1.6, 2.4), random.uniform(-0.5, 0.5));
    tracker.update(withObject(evenScan(1.0 + 0.2 * i, 4.0), p, 0.15), {}, [](const Vec&) { return false; });
    EXPECT_TRUE(tracker.moving().empty()) << i;
  }
}

TEST(ObstacleTracker, TakesNothingNarrowForAWalker) {
  ObstacleTracker tracker(ObstacleTrackerParams{});
  for (int i = 0; i < 15; ++i) {
    const LaserScan scan = withObject(evenScan(1.0 + 0.2 * i, 4.0), {2.0, -0.7 + 0.1 * i}, 0.03);
    tracker.update(scan, {}, [](const Vec&) { return false; });
    EXPECT_TRUE(tracker.moving().empty()) << i;
  }
}

}  // namespace
}  // namespace frugal_nav
