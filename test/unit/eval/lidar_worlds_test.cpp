#include "../../../src/eval/lidar_worlds.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace frugal_nav::eval {
namespace {

constexpr double kDoor_m = 0.29;
constexpr double kGap_m = 0.35;

bool isFree(const RandomWorld& world, double disc_radius_m) {
  Eigen::AlignedBox2d bounds;
  for (const Solid& solid : world.solids) {
    for (const Eigen::Vector2d& corner : solid.outline()) bounds.extend(corner);
  }
  return FreeSpace(bounds, world.solids, disc_radius_m)
      .pathLength(world.start.position(), world.goal.position())
      .has_value();
}

double distanceToAny(const RandomWorld& world, const Eigen::Vector2d& p) {
  double nearest_m = 10.0;
  for (const Solid& solid : world.solids) nearest_m = std::min(nearest_m, solid.distanceTo(p));
  return nearest_m;
}

TEST(LidarWorlds, TheDoorwayIsTheOnlyWayAndAsWideAsAsked) {
  for (std::uint64_t seed = 500000; seed < 500020; ++seed) {
    const RandomWorld world = makeDoorwayWorld(seed, kDoor_m).place;
    EXPECT_LT(world.start.x_m, world.goal.x_m);
    // The grid of the search has cells of 5 cm.
    EXPECT_TRUE(isFree(world, 0.5 * kDoor_m - 0.05)) << seed;
    EXPECT_FALSE(isFree(world, 0.5 * kDoor_m + 0.01)) << seed;
    EXPECT_GT(distanceToAny(world, world.start.position()), 0.25);
    EXPECT_GT(distanceToAny(world, world.goal.position()), 0.25);
  }
}

TEST(LidarWorlds, TheThingStandsBesideTheGoalByItsGap) {
  for (std::uint64_t seed = 500000; seed < 500020; ++seed) {
    const RandomWorld world = makeNearTargetWorld(seed, kGap_m).place;
    EXPECT_NEAR(distanceToAny(world, world.goal.position()), kGap_m, 1e-6) << seed;
  }
}

TEST(LidarWorlds, ThreeThingsCrossTheHall) {
  for (std::uint64_t seed = 500000; seed < 500020; ++seed) {
    const LidarWorld world = makeMovingWorld(seed);
    EXPECT_EQ(world.movers.size() + world.place.scene.people.size(), 3U);
    EXPECT_TRUE(isFree(world.place, 0.3)) << "none of them is a solid that stays";
    for (const Mover& mover : world.movers) {
      EXPECT_GE(mover.speed_mps, 0.3);
      EXPECT_LE(mover.speed_mps, 1.0);
      EXPECT_GT((mover.to - mover.from).norm(), 2.0);
    }
  }
}

TEST(LidarWorlds, AMoverGoesToAndFro) {
  const Mover mover{0, {0.0, 0.0}, {0.0, 2.0}, 0.5, 1.0};
  EXPECT_NEAR(mover.at(0.0).y(), 0.5, 1e-12);  // it began a second before
  EXPECT_NEAR(mover.at(3.0).y(), 2.0, 1e-12);
  EXPECT_NEAR(mover.at(5.0).y(), 1.0, 1e-12);
  EXPECT_NEAR(mover.at(8.0).y(), 0.5, 1e-12);
}

TEST(LidarWorlds, ASeedIsAWorld) {
  const auto startOf = [](std::uint64_t seed) { return makeDoorwayWorld(seed, kDoor_m).place.start; };
  EXPECT_EQ(distance(startOf(500001), startOf(500001)), 0.0);
  EXPECT_GT(distance(startOf(500001), startOf(500002)), 0.0);
}

}  // namespace
}  // namespace frugal_nav::eval
