#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <frugal_nav/planning/tight_passage.hpp>

namespace frugal_nav {
namespace {

using Line = std::vector<Eigen::Vector2d>;

constexpr double kReach_m = 0.4;

/// A wall along x = 1 with a door of 0.3 m whose middle is at y = 0.2; a return every 2 cm.
std::vector<WindowPoint> wallWithDoor() {
  std::vector<WindowPoint> points;
  for (int i = 0; i <= 50; ++i) {
    points.push_back({{1.0, 0.35 + 0.02 * i}, 1.0});
    points.push_back({{1.0, 0.05 - 0.02 * i}, 1.0});
  }
  return points;
}

TEST(TightPassage, IsAsWideAsTheReturnsSay) {
  const auto passage = passageAt({1.02, 0.17}, wallWithDoor(), kReach_m);  // beside its middle
  ASSERT_TRUE(passage);
  EXPECT_NEAR(passage->width_m, 0.30, 1e-9);
  EXPECT_NEAR(passage->middle_odom.x(), 1.0, 1e-9);
  EXPECT_NEAR(passage->middle_odom.y(), 0.2, 1e-9);
  EXPECT_NEAR(std::abs(passage->along_odom.x()), 1.0, 1e-9);
}

TEST(TightPassage, IsNoneBesideAWallInTheOpenOrOnAReturn) {
  EXPECT_FALSE(passageAt({0.8, 0.9}, wallWithDoor(), kReach_m)) << "one side is open";
  EXPECT_FALSE(passageAt({-1.0, 0.2}, wallWithDoor(), kReach_m));
  EXPECT_FALSE(passageAt({1.0, 0.2}, wallWithDoor(), 0.14)) << "wider than it is asked for";
  EXPECT_FALSE(passageAt({1.0, 0.35}, wallWithDoor(), kReach_m));
  EXPECT_FALSE(passageAt({1.0, 0.2}, {}, kReach_m));
}

TEST(TightPassage, ALineIsLedStraightThroughItsMiddle) {
  const auto passage = passageAt({1.0, 0.2}, wallWithDoor(), kReach_m);
  ASSERT_TRUE(passage);
  for (const bool back : {false, true}) {
    Line line{{0.0, -1.0}, {0.9, 0.1}, {1.1, 0.3}, {2.0, 1.0}};
    if (back) std::reverse(line.begin(), line.end());
    const Line led = leadThrough(line, *passage, 0.5);
    ASSERT_EQ(led.size(), 5U);
    EXPECT_EQ(led.front(), line.front());
    EXPECT_EQ(led.back(), line.back());
    const double side = back ? -1.0 : 1.0;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector2d& p = led[static_cast<std::size_t>(i + 1)];
      EXPECT_NEAR(p.x(), 1.0 + side * 0.5 * (i - 1), 1e-9) << "in driving order";
      EXPECT_NEAR(p.y(), 0.2, 1e-9);
    }
  }
}

TEST(TightPassage, ALineThatEndsInItIsNotLedBeyond) {
  const auto passage = passageAt({1.0, 0.2}, wallWithDoor(), kReach_m);
  ASSERT_TRUE(passage);
  const Line led = leadThrough({{0.0, 0.0}, {0.7, 0.1}, {1.2, 0.2}}, *passage, 0.5);
  ASSERT_EQ(led.size(), 4U);
  EXPECT_NEAR(led[1].x(), 0.5, 1e-9);
  EXPECT_NEAR(led[2].x(), 1.0, 1e-9);
  EXPECT_EQ(led.back(), Eigen::Vector2d(1.2, 0.2));
}

TEST(TightPassage, ALineElsewhereStays) {
  const auto passage = passageAt({1.0, 0.2}, wallWithDoor(), kReach_m);
  ASSERT_TRUE(passage);
  const Line line{{0.0, 3.0}, {2.0, 3.0}};
  EXPECT_EQ(leadThrough(line, *passage, 0.5), line);
}

}  // namespace
}  // namespace frugal_nav
