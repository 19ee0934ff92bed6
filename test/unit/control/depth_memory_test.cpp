#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <frugal_nav/control/depth_memory.hpp>

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

std::vector<Eigen::Vector2d> seenAt(const DepthMemory& memory, double at_s, const Pose2& pose = {}) {
  return memory.pointsAt(kStart + fromSeconds(at_s), pose);
}

/// One point 1 m straight ahead of the origin of odom.
DepthMemory withPoint() {
  DepthMemory memory{DepthMemoryParams{}};
  LaserScan scan = view(0.0);
  scan.ranges_m[30] = 1.0F;
  memory.add(scan, {});
  return memory;
}

TEST(DepthMemory, MovesWithTheOdometry) {
  const auto points = seenAt(withPoint(), 1.0, {0.4, 0.0, M_PI / 2.0});
  ASSERT_EQ(points.size(), 1U);
  EXPECT_NEAR(points[0].x(), 0.0, 1e-6);  // the range is a float
  EXPECT_NEAR(points[0].y(), -0.6, 1e-6);
}

TEST(DepthMemory, KeepsWhatLeftTheView) {
  DepthMemory memory = withPoint();
  memory.add(view(1.0), {0.0, 0.0, M_PI / 2.0});
  EXPECT_EQ(seenAt(memory, 1.0).size(), 1U);
}

TEST(DepthMemory, ForgetsWhatIsSeenThrough) {
  DepthMemory memory = withPoint();
  memory.add(view(0.1), {});
  EXPECT_TRUE(seenAt(memory, 0.1).empty());
}

TEST(DepthMemory, KeepsWhatIsHiddenOrUnknown) {
  DepthMemory hidden = withPoint();
  hidden.add(view(0.1, 0.8F), {});
  const auto points = seenAt(hidden, 0.1);
  EXPECT_TRUE(std::any_of(points.begin(), points.end(), [](const auto& p) { return p.norm() > 0.9; }));
  DepthMemory unknown = withPoint();
  unknown.add(view(0.1, std::nanf("")), {});
  EXPECT_EQ(seenAt(unknown, 0.1).size(), 1U);
}

TEST(DepthMemory, KeepsWhatIsBelowTheView) {
  DepthMemory memory = withPoint();
  memory.add(view(2.0), {0.6, 0.0, 0.0});  // 0.4 m before it, the camera looks over it
  EXPECT_EQ(seenAt(memory, 2.0).size(), 1U);
}

TEST(DepthMemory, ForgetsWithTime) {
  DepthMemory memory = withPoint();
  EXPECT_EQ(seenAt(memory, 4.9).size(), 1U);
  EXPECT_TRUE(seenAt(memory, 5.1).empty());
}

TEST(DepthMemory, KeepsOnePointACellAndNothingFar) {
  DepthMemory memory{DepthMemoryParams{}};
  for (int i = 0; i < 50; ++i) memory.add(view(0.1 * i, 1.0F), {});
  EXPECT_LE(seenAt(memory, 5.0).size(), 61U);
  memory.clear();
  memory.add(view(6.0, 2.0F), {});
  EXPECT_TRUE(seenAt(memory, 6.0).empty());
}

TEST(DepthMemory, NamesAParameterOutOfItsRange) {
  DepthMemoryParams params;
  params.memory_s = -1.0;
  EXPECT_THROW(DepthMemory{params}, ConfigError);
}

}  // namespace
}  // namespace frugal_nav
