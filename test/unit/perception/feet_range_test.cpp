#include <cmath>
#include <limits>
#include <optional>

#include <gtest/gtest.h>

#include <frugal_nav/perception/feet_range.hpp>

namespace frugal_nav {
namespace {

/// A person's surface ahead, 0.3 m wide, before a wall.
LaserScan surfaces(double person_m, double wall_m = 4.9) {
  LaserScan scan;
  scan.angle_min_rad = -0.5;
  scan.angle_increment_rad = 0.01;
  scan.range_min_m = 0.1;
  scan.range_max_m = 5.0;
  for (int i = 0; i <= 100; ++i) {
    const bool person = std::abs(scan.angleOf(static_cast<std::size_t>(i))) < 0.15 / person_m;
    scan.ranges_m.push_back(static_cast<float>(person ? person_m : wall_m));
  }
  return scan;
}

std::optional<double> ahead(double thought_m, const LaserScan& scan) {
  return bodyRange(0.0, thought_m, scan, FeetParams{});
}

TEST(FeetRange, TellsWhereThePersonStands) {
  const std::optional<double> range_m = ahead(2.5, surfaces(2.85));
  ASSERT_TRUE(range_m);
  EXPECT_NEAR(*range_m, 3.0, 1e-6);  // the body's middle is 0.15 m behind its surface
}

TEST(FeetRange, WhatStandsElsewhereIsNotThePerson) {
  EXPECT_FALSE(ahead(3.5, surfaces(1.2))) << "an obstacle hides the feet";
  EXPECT_FALSE(ahead(3.0, surfaces(4.2))) << "the wall behind";
  EXPECT_FALSE(ahead(5.0, surfaces(4.8, 5.0))) << "too far to tell";
  LaserScan nothing = surfaces(2.85);
  for (float& range_m : nothing.ranges_m) range_m = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(ahead(2.5, nothing));
}

TEST(FeetRange, AWallDoesNotStandFree) {
  EXPECT_TRUE(standsFree(0.0, 2.5, surfaces(2.35), FeetParams{}));
  EXPECT_FALSE(standsFree(0.0, 2.5, surfaces(2.35, 2.35), FeetParams{}));
}

}  // namespace
}  // namespace frugal_nav
