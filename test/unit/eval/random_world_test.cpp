#include <set>

#include <gtest/gtest.h>

#include <frugal_nav/eval/random_world.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kDisc_m = 0.3;

TEST(FreeSpace, FindsTheWayAroundAWall) {
  // A wall from y = 0 to 3 in a 4 m square: a disc of 0.25 m goes round its end at (2, 3).
  Solid wall;
  wall.world_from_solid = {2.0, 1.5, 0.0};
  wall.size_m = {0.1, 3.0};
  const FreeSpace space({Eigen::Vector2d(0, 0), Eigen::Vector2d(4, 4)}, {wall}, 0.25);
  EXPECT_FALSE(space.isFree({2.0, 1.0}));
  EXPECT_FALSE(space.isFree({2.0, 3.2}));
  EXPECT_TRUE(space.isFree({2.0, 3.3}));
  const auto length = space.pathLength({1.0, 1.0}, {3.0, 1.0});
  ASSERT_TRUE(length);
  // No shorter than two straights of hypot(1, 2.25) m; no longer than the 8-connected way through (1.7, 3),
  // (1.75, 3.25), (2.25, 3.25), (2.3, 3), which is 5.62 m; two cells of tolerance each.
  EXPECT_GT(*length, 2.0 * 2.46 - 0.1);
  EXPECT_LT(*length, 5.62 + 0.1);
}

TEST(FreeSpace, ClosedWallHasNoWayThrough) {
  Solid wall;
  wall.world_from_solid = {2.0, 2.0, 0.0};
  wall.size_m = {0.1, 3.6};  // leaves 0.2 m at both ends
  const FreeSpace space({Eigen::Vector2d(0, 0), Eigen::Vector2d(4, 4)}, {wall}, 0.25);
  EXPECT_FALSE(space.pathLength({1.0, 1.0}, {3.0, 1.0}));
}

TEST(RandomWorld, SameSeedGivesTheSameWorld) {
  const RandomWorld a = makeRandomWorld(500123, kDisc_m);
  const RandomWorld b = makeRandomWorld(500123, kDisc_m);
  EXPECT_EQ(a.start.x_m, b.start.x_m);
  EXPECT_EQ(a.path_length_m, b.path_length_m);
  ASSERT_EQ(a.scene.models.size(), b.scene.models.size());
  for (std::size_t i = 0; i < a.scene.models.size(); ++i) {
    EXPECT_EQ(a.scene.models[i].name, b.scene.models[i].name);
    EXPECT_EQ(a.scene.models[i].world_from_model.matrix(), b.scene.models[i].world_from_model.matrix());
  }
}

TEST(RandomWorld, StartAndGoalAreFreeConnectedAndApart) {
  std::set<std::string> kinds;
  for (std::uint64_t seed = 500000; seed < 500040; ++seed) {
    const RandomWorld world = makeRandomWorld(seed, kDisc_m);
    kinds.insert(world.kind);
    for (const Solid& solid : world.solids) {
      if (solid.overhang) continue;
      // The free-space map is true at the centres of its cells of 0.05 m: half a diagonal off at most.
      EXPECT_GT(solid.distanceTo(world.start.position()), kDisc_m - 0.036) << "seed " << seed;
      EXPECT_GT(solid.distanceTo(world.goal.position()), kDisc_m - 0.036) << "seed " << seed;
    }
    EXPECT_GT(distance(world.start, world.goal), 2.0) << "seed " << seed;
    // Both lie within their cells: at most a diagonal each is lost.
    EXPECT_GE(world.path_length_m, distance(world.start, world.goal) - 0.15) << "seed " << seed;
  }
  EXPECT_EQ(kinds, (std::set<std::string>{"bend", "corridor", "room"}));
}

TEST(RandomWorld, MeshesMatchCollisionShapes) {
  const RandomWorld world = makeRandomWorld(500007, kDisc_m);
  for (const sim::Model& model : world.scene.models) {
    ASSERT_EQ(model.visuals.size(), model.collisions.size());
    for (std::size_t i = 0; i < model.visuals.size(); ++i) {
      const sim::Mesh& mesh = world.scene.meshes.at(static_cast<std::size_t>(model.visuals[i].mesh));
      EXPECT_EQ(mesh.triangle_material.size(), mesh.triangles.size());
      EXPECT_EQ(model.visuals[i].model_from_visual.matrix(),
                model.collisions[i].model_from_collision.matrix());
    }
  }
}

}  // namespace
}  // namespace frugal_nav::eval
