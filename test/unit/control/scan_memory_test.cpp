#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <frugal_nav/control/scan_memory.hpp>

namespace frugal_nav {
namespace {

constexpr float kFree = std::numeric_limits<float>::infinity();
const Stamp kStart = stampFromSeconds(10.0);

/// A view of 60 degrees, a beam a degree: beam 30 looks straight ahead.
LaserScan view(double at_s, float all = kFree) {
  LaserScan scan;
  scan.stamp = kStart + fromSeconds(at_s);
  scan.angle_min_rad = -30.0 / 180.0 * M_PI;
  scan.angle_increment_rad = M_PI / 180.0;
  scan.range_min_m = 0.1;
  scan.range_max_m = 5.0;
  scan.ranges_m.assign(61, all);
  return scan;
}

std::vector<Eigen::Vector2d> seenAt(const ScanMemory& memory, double at_s, const Pose2& pose = {}) {
  return memory.pointsAt(kStart + fromSeconds(at_s), pose);
}

/// One point 1 m straight ahead of the origin of odom, last seen at 0 s.
ScanMemory withPoint(int sightings = 2) {
  ScanMemory memory{ScanMemoryParams{}};
  for (int i = sightings - 1; i >= 0; --i) {
    LaserScan scan = view(-0.1 * i);
    scan.ranges_m[30] = 1.0F;
    memory.add(scan, {}, {});
  }
  return memory;
}

TEST(ScanMemory, MovesWithTheOdometry) {
  const auto points = seenAt(withPoint(), 1.0, {0.4, 0.0, M_PI / 2.0});
  ASSERT_EQ(points.size(), 1U);
  EXPECT_NEAR(points[0].x(), 0.0, 1e-6);  // the range is a float
  EXPECT_NEAR(points[0].y(), -0.6, 1e-6);
}

TEST(ScanMemory, KeepsWhatLeftTheView) {
  ScanMemory memory = withPoint();
  memory.add(view(1.0), {}, {0.0, 0.0, M_PI / 2.0});
  EXPECT_EQ(seenAt(memory, 1.0).size(), 1U);
}

TEST(ScanMemory, ForgetsWhatIsSeenThrough) {
  ScanMemory memory = withPoint();
  memory.add(view(0.1), {}, {});
  EXPECT_TRUE(seenAt(memory, 0.1).empty());
}

TEST(ScanMemory, KeepsWhatIsHiddenOrUnknown) {
  ScanMemory hidden = withPoint();
  hidden.add(view(0.1, 0.8F), {}, {});
  const auto points = seenAt(hidden, 0.1);
  EXPECT_TRUE(std::any_of(points.begin(), points.end(), [](const auto& p) { return p.norm() > 0.9; }));
  ScanMemory unknown = withPoint();
  unknown.add(view(0.1, std::nanf("")), {}, {});
  EXPECT_EQ(seenAt(unknown, 0.1).size(), 1U);
}

TEST(ScanMemory, KeepsWhatIsBelowTheView) {
  ScanMemory memory = withPoint();
  memory.add(view(2.0), {}, {0.6, 0.0, 0.0});  // 0.4 m before it, the camera looks over it
  EXPECT_EQ(seenAt(memory, 2.0).size(), 1U);
}

TEST(ScanMemory, TakesBackWhatOnlyOneScanHasSeen) {
  ScanMemory memory = withPoint(1);
  memory.add(view(0.1), {}, {0.6, 0.0, 0.0});
  EXPECT_TRUE(seenAt(memory, 0.1).empty());
}

TEST(ScanMemory, ForgetsWithTime) {
  ScanMemory memory = withPoint();
  EXPECT_EQ(seenAt(memory, 4.9).size(), 1U);
  EXPECT_TRUE(seenAt(memory, 5.1).empty());
}

TEST(ScanMemory, KeepsOnePointACellAndNothingFar) {
  ScanMemory memory{ScanMemoryParams{}};
  for (int i = 0; i < 50; ++i) memory.add(view(0.1 * i, 1.0F), {}, {});
  EXPECT_LE(seenAt(memory, 5.0).size(), 61U);
  memory.clear();
  memory.add(view(6.0, 2.0F), {}, {});
  EXPECT_TRUE(seenAt(memory, 6.0).empty());
}

/// All around, a beam a degree, from straight behind: beam 180 looks straight ahead.
LaserScan turn(double at_s, float all = 2.0F) {
  LaserScan scan = view(at_s);
  scan.angle_min_rad = -M_PI;
  scan.range_min_m = 0.15;
  scan.ranges_m.assign(360, all);
  return scan;
}

/// A laser that has seen one point, 0.2 m to its left.
ScanMemory withPointBeside() {
  ScanMemory memory{ScanMemoryParams::ofLaser()};
  LaserScan scan = turn(0.0);
  scan.ranges_m[270] = 0.2F;
  memory.add(scan, {}, {});
  return memory;
}

TEST(ScanMemory, KeepsWhatABeamBesideItCallsTooNear) {
  // From 0.1 m the point's tolerance of 0.02 m covers 11 beams to either side.
  for (const std::size_t beam : {270U, 262U, 278U}) {
    ScanMemory memory = withPointBeside();
    for (int i = 1; i <= 50; ++i) {
      LaserScan scan = turn(0.1 * i);
      scan.ranges_m[beam] = -kFree;
      memory.add(scan, {}, {0.0, 0.1, 0.0});
    }
    EXPECT_EQ(seenAt(memory, 5.0).size(), 1U) << "beam " << beam << ": it is kept as long as that holds";
  }
}

TEST(ScanMemory, KnowsTheCornersOfAJambThatIsTooNear) {
  ScanMemory memory{ScanMemoryParams::ofLaser()};
  LaserScan seen = turn(0.0);
  LaserScan too_near = turn(0.1);
  for (std::size_t beam = 265; beam <= 275; ++beam) {  // a face 0.2 m to the left
    seen.ranges_m[beam] =
        static_cast<float>(0.2 / std::cos((static_cast<double>(beam) - 270.0) / 180.0 * M_PI));
    too_near.ranges_m[beam] = -kFree;
  }
  memory.add(seen, {}, {});
  memory.add(too_near, {}, {0.0, 0.1, 0.0});
  const auto points = seenAt(memory, 0.1);
  for (const double side : {1.0, -1.0}) {
    const Eigen::Vector2d corner(side * 0.2 * std::tan(5.0 / 180.0 * M_PI), 0.2);
    double nearest_m = 1.0;
    for (const Eigen::Vector2d& p : points) nearest_m = std::min(nearest_m, (p - corner).norm());
    EXPECT_LT(nearest_m, 0.005) << "less than half the least air that the collision stop keeps";
  }
}

TEST(ScanMemory, ForgetsWhatALaserMeasuresAnewOrSeesPast) {
  ScanMemory past = withPointBeside();
  past.add(turn(0.1), {}, {0.0, 0.1, 0.0});
  EXPECT_TRUE(seenAt(past, 0.1).empty());
  ScanMemory anew = withPointBeside();
  LaserScan scan = turn(0.1);
  scan.ranges_m[270] = 0.19F;
  anew.add(scan, {}, {});
  const auto points = seenAt(anew, 0.1);
  ASSERT_EQ(points.size(), 1U) << "noise must not make it grow";
  EXPECT_NEAR(points[0].y(), 0.19, 1e-6);
}

TEST(ScanMemory, SeesFromTheSensorsPlace) {
  ScanMemory memory{ScanMemoryParams::ofLaser()};
  LaserScan scan = turn(0.0);
  scan.ranges_m[180] = 0.2F;
  const Pose2 base_from_laser{0.1, 0.0, M_PI / 2.0};
  memory.add(scan, base_from_laser, {});
  const auto points = seenAt(memory, 0.0);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_NEAR(points[0].x(), 0.1, 1e-6);
  EXPECT_NEAR(points[0].y(), 0.2, 1e-6);
  LaserScan ahead_only = turn(0.1, std::nanf(""));
  for (std::size_t beam = 170; beam <= 190; ++beam) ahead_only.ranges_m[beam] = 2.0F;
  memory.add(ahead_only, base_from_laser, {});
  EXPECT_TRUE(seenAt(memory, 0.1).empty()) << "its laser sees past it straight ahead";
}

TEST(ScanMemory, NamesAParameterOutOfItsRange) {
  ScanMemoryParams params;
  params.memory_s = -1.0;
  EXPECT_THROW(ScanMemory{params}, ConfigError);
}

}  // namespace
}  // namespace frugal_nav
