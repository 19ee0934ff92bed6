#include "flat_world.hpp"

#include <gtest/gtest.h>

#include <frugal_nav/planning/rolling_grid.hpp>

namespace frugal_nav {
namespace {

using planning_test::FlatWorld;
using State = RollingGrid::State;

/// One beam straight ahead.
LaserScan beam(float range_m, double stamp_s = 0.0) {
  LaserScan scan;
  scan.stamp = stampFromSeconds(stamp_s);
  scan.angle_increment_rad = 0.01;
  scan.range_min_m = 0.15;
  scan.range_max_m = 12.0;
  scan.ranges_m = {range_m};
  return scan;
}

class RollingGridTest : public testing::Test {
 protected:
  State stateAt(double x, double y) const { return grid.state(grid.cellOf({x, y})); }
  int certaintyAt(double x, double y) const { return grid.certainty(grid.cellOf({x, y})); }

  RollingGrid grid{RollingGridParams{}};
  // Beams run through the middle of a row of cells.
  const Pose2 kMiddle{0.025, 0.025, 0.0};
};

TEST_F(RollingGridTest, UnknownIsNotFree) {
  EXPECT_EQ(stateAt(1.0, 1.0), State::kUnknown);
  grid.insert(beam(2.0F), kMiddle);
  EXPECT_EQ(stateAt(1.0, 0.025), State::kFree);
  EXPECT_EQ(stateAt(2.025, 0.025), State::kOccupied);
  EXPECT_EQ(stateAt(2.125, 0.025), State::kUnknown);
  EXPECT_EQ(stateAt(1.0, 1.0), State::kUnknown);
  EXPECT_EQ(stateAt(100.0, 0.0), State::kUnknown);
}

TEST_F(RollingGridTest, ReadsRangesByRep117) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  grid.insert(beam(std::numeric_limits<float>::quiet_NaN()), kMiddle);
  EXPECT_EQ(stateAt(0.525, 0.025), State::kUnknown);
  grid.insert(beam(13.0F), kMiddle);  // beyond range_max: unknown too
  EXPECT_EQ(stateAt(0.525, 0.025), State::kUnknown);
  grid.insert(beam(kInf), kMiddle);
  EXPECT_EQ(stateAt(0.525, 0.025), State::kFree);
  EXPECT_EQ(stateAt(4.9, 0.025), State::kFree);
  grid.insert(beam(-kInf), kMiddle);
  EXPECT_EQ(stateAt(0.025 + 0.15 + 0.001, 0.025), State::kOccupied);
}

TEST_F(RollingGridTest, InfinityClearsNoFartherThanAllowed) {
  RollingGridParams params;
  params.max_range_m = 2.0;
  grid = RollingGrid(params);
  grid.insert(beam(std::numeric_limits<float>::infinity()), kMiddle);
  EXPECT_EQ(stateAt(1.975, 0.025), State::kFree);
  EXPECT_EQ(stateAt(2.125, 0.025), State::kUnknown);
  grid.insert(beam(3.0F), kMiddle);
  EXPECT_EQ(stateAt(3.025, 0.025), State::kUnknown);
}

TEST_F(RollingGridTest, GainsAndLosesCertainty) {
  grid.insert(beam(2.0F, 0.0), kMiddle);
  EXPECT_EQ(certaintyAt(2.025, 0.025), 4);
  for (int i = 1; i < 10; ++i) grid.insert(beam(2.0F, 0.1 * i), kMiddle);
  EXPECT_EQ(certaintyAt(2.025, 0.025), 12);
  // Twelve scans through it, and it is free; the thirteenth cannot make it freer.
  for (int i = 0; i < 11; ++i) grid.insert(beam(3.0F, 1.0 + 0.1 * i), kMiddle);
  EXPECT_EQ(stateAt(2.025, 0.025), State::kOccupied);
  grid.insert(beam(3.0F, 2.2), kMiddle);
  EXPECT_EQ(stateAt(2.025, 0.025), State::kFree);
  grid.insert(beam(3.0F, 2.3), kMiddle);
  grid.insert(beam(2.0F, 2.4), kMiddle);
  EXPECT_EQ(stateAt(2.025, 0.025), State::kOccupied);
}

TEST_F(RollingGridTest, ManyHitsOfOneScanCountOnce) {
  LaserScan two = beam(2.0F);
  two.angle_increment_rad = 1e-4;
  two.ranges_m = {2.0F, 2.0F};
  grid.insert(two, kMiddle);
  EXPECT_EQ(certaintyAt(2.025, 0.025), 4);
}

TEST_F(RollingGridTest, HitOutweighsRaysOfTheSameScan) {
  LaserScan two = beam(3.0F);
  two.angle_increment_rad = 1e-4;
  two.ranges_m = {3.0F, 2.0F};
  grid.insert(two, kMiddle);
  EXPECT_EQ(certaintyAt(2.025, 0.025), 4);
}

TEST_F(RollingGridTest, ForgetsWhatIsNotSeenAgain) {
  grid.insert(beam(2.0F, 100.0), kMiddle);
  const Pose2 away{0.025, 0.025, M_PI / 2};
  grid.insert(beam(2.0F, 119.9), away);
  EXPECT_EQ(stateAt(2.025, 0.025), State::kOccupied);
  EXPECT_EQ(stateAt(1.0, 0.025), State::kFree);
  grid.insert(beam(2.0F, 120.1), away);
  EXPECT_EQ(stateAt(2.025, 0.025), State::kUnknown);
  EXPECT_EQ(stateAt(1.0, 0.025), State::kUnknown);
  EXPECT_EQ(certaintyAt(2.025, 0.025), 0);
  // A forgotten cell starts anew: one ray through it frees it.
  grid.insert(beam(3.0F, 120.2), kMiddle);
  EXPECT_EQ(stateAt(2.025, 0.025), State::kFree);
}

TEST_F(RollingGridTest, RollingKeepsCellsInTheirPlaces) {
  const FlatWorld world = FlatWorld().box(-1.52, -2.13, 2.48, 1.63);
  grid.insert(world.scan({}), {});
  const RollingGrid before = grid;
  const Eigen::Vector2d moves[] = {{0.73, -1.31}, {-0.62, 0.94}, {1.2, 1.2}};
  for (const Eigen::Vector2d& move : moves) {
    grid.moveTo(move);
    int kept = 0;
    for (int y = grid.origin().y; y < grid.origin().y + grid.size(); ++y) {
      for (int x = grid.origin().x; x < grid.origin().x + grid.size(); ++x) {
        const bool inside = std::abs(x) <= 60 && std::abs(y) <= 60;  // never left the window
        if (!inside) continue;
        ASSERT_EQ(grid.state({x, y}), before.state({x, y})) << x << ' ' << y;
        if (grid.state({x, y}) == State::kOccupied) ++kept;
      }
    }
    EXPECT_GT(kept, 100);
  }
}

TEST_F(RollingGridTest, WhatLeavesTheWindowIsForgotten) {
  grid.insert(beam(2.0F), kMiddle);
  grid.moveTo({-3.5, 0.0});
  EXPECT_EQ(stateAt(2.025, 0.025), State::kUnknown);
  grid.moveTo({0.0, 0.0});
  EXPECT_EQ(stateAt(2.025, 0.025), State::kUnknown);
  EXPECT_EQ(stateAt(1.025, 0.025), State::kFree);
  grid.moveTo({1000.0, -1000.0});  // farther than the window: nothing is left
  grid.moveTo({0.0, 0.0});
  EXPECT_EQ(stateAt(1.025, 0.025), State::kUnknown);
}

TEST_F(RollingGridTest, RowsAreTheStatesOfTheWindow) {
  grid.moveTo({0.4, -0.3});
  grid.insert(FlatWorld().box(-1, -1, 1.5, 1).scan({0.4, -0.3, 0.2}), {0.4, -0.3, 0.2});
  std::vector<State> row(static_cast<std::size_t>(grid.size()));
  for (int y = grid.origin().y; y < grid.origin().y + grid.size(); ++y) {
    grid.copyRow(y, row.data());
    for (int i = 0; i < grid.size(); ++i) {
      ASSERT_EQ(row[static_cast<std::size_t>(i)], grid.state({grid.origin().x + i, y}));
    }
  }
}

TEST(RollingGridParams, NamesImpossibleSizes) {
  RollingGridParams params;
  params.cell_m = 0.5;
  params.window_m = 2.0;
  EXPECT_THROW(RollingGrid{params}, ConfigError);
}

}  // namespace
}  // namespace frugal_nav
