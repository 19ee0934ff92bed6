#include "box_scene.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include <frugal_nav/sim/ray_tracer.hpp>

namespace frugal_nav::sim {
namespace {

// Embree computes in float: at 10 m one unit in the last place is 1e-6 m.
constexpr double kTolerance_m = 1e-5;

TEST(RayTracer, MeasuresTheDistanceToABoxFace) {
  BoxScene world;
  world.addBox({1.0F, 2.0F, 3.0F}, at(4.0, 0.0, 0.0), world.addMaterial({1, 1, 1}));
  const RayTracer tracer(world.scene);
  EXPECT_NEAR(tracer.range({0, 0, 0}, {1, 0, 0}, 100.0).value(), 3.5, kTolerance_m);
  EXPECT_NEAR(tracer.range({0, 0, 0}, {5, 0, 0}, 100.0).value(), 3.5, kTolerance_m) << "direction not unit";
  // A slanted ray meets x = 3.5 at y = 0.7.
  EXPECT_NEAR(tracer.range({0, 0, 0}, {1, 0.2, 0}, 100.0).value(), 3.5 * std::hypot(1.0, 0.2), kTolerance_m);
  EXPECT_FALSE(tracer.range({0, 0, 0}, {-1, 0, 0}, 100.0));
  EXPECT_FALSE(tracer.range({0, 0, 0}, {1, 0, 0}, 3.4)) << "farther than asked";
}

TEST(RayTracer, HitsARotatedBoxWhereItIs) {
  BoxScene world;
  Eigen::Isometry3d pose = at(4.0, 0.0, 0.0);
  pose.linear() = Eigen::AngleAxisd(M_PI / 4.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  world.addBox({1.0F, 1.0F, 1.0F}, pose, world.addMaterial({1, 1, 1}));
  const RayTracer tracer(world.scene);
  // At y = 0.1 the edge at 4 - sqrt(1/2) has receded by 0.1.
  EXPECT_NEAR(tracer.range({0, 0.1, 0}, {1, 0, 0}, 100.0).value(), 4.1 - M_SQRT1_2, kTolerance_m);
}

TEST(RayTracer, MovingAModelMovesItsHits) {
  BoxScene world;
  const int white = world.addMaterial({1, 1, 1});
  world.addBox({1.0F, 1.0F, 1.0F}, at(8.0, 0.0, 0.0), white);
  const int moving = world.addBox({1.0F, 1.0F, 1.0F}, at(4.0, 0.0, 0.0), white);
  RayTracer tracer(world.scene);
  for (const double x : {3.0, 5.0, 4.0, 4.25}) {  // 4.0 is where it was at first
    world.scene.models[static_cast<std::size_t>(moving)].world_from_model = at(x, 0.0, 0.0);
    tracer.updateModel(moving);
    tracer.commit();
    EXPECT_NEAR(tracer.range({0, 0, 0}, {1, 0, 0}, 100.0).value(), x - 0.5, kTolerance_m);
  }
  world.scene.models[static_cast<std::size_t>(moving)].world_from_model = at(4.0, 3.0, 0.0);
  tracer.updateModel(moving);
  tracer.commit();
  EXPECT_NEAR(tracer.range({0, 0, 0}, {1, 0, 0}, 100.0).value(), 7.5, kTolerance_m) << "what stood behind it";
}

TEST(RayTracer, MovingOneLimbLeavesTheOthers) {
  BoxScene world;
  const int body = world.addBox({1.0F, 1.0F, 1.0F}, at(4.0, 0.0, 0.0), world.addMaterial({1, 1, 1}));
  Model& model = world.scene.models[static_cast<std::size_t>(body)];
  model.visuals.push_back({model.visuals[0].mesh, at(0.0, 3.0, 0.0)});
  RayTracer tracer(world.scene);
  model.visuals[1].model_from_visual = at(1.0, 3.0, 0.0);
  tracer.updateModel(body);
  tracer.commit();
  EXPECT_NEAR(tracer.range({0, 0, 0}, {1, 0, 0}, 100.0).value(), 3.5, kTolerance_m);
  EXPECT_NEAR(tracer.range({0, 3, 0}, {1, 0, 0}, 100.0).value(), 4.5, kTolerance_m);
}

TEST(RayTracer, HiddenModelIsNotSeen) {
  for (const bool moved_before : {false, true}) {
    BoxScene world;
    const int robot = world.addBox({1.0F, 1.0F, 1.0F}, at(4.0, 0.0, 0.0), world.addMaterial({1, 1, 1}));
    RayTracer tracer(world.scene);
    if (moved_before) {
      world.scene.models[0].world_from_model = at(4.5, 0.0, 0.0);
      tracer.updateModel(robot);
      tracer.commit();
    }
    tracer.setVisible(robot, false);
    tracer.commit();
    EXPECT_FALSE(tracer.range({0, 0, 0}, {1, 0, 0}, 100.0));
    world.scene.models[0].world_from_model = at(5.0, 0.0, 0.0);
    tracer.updateModel(robot);
    tracer.commit();
    EXPECT_FALSE(tracer.range({0, 0, 0}, {1, 0, 0}, 100.0)) << "moving must not show it";
    tracer.setVisible(robot, true);
    tracer.commit();
    EXPECT_NEAR(tracer.range({0, 0, 0}, {1, 0, 0}, 100.0).value(), 4.5, kTolerance_m);
  }
}

TEST(RayTracer, EmptySceneHasNothingToHit) {
  const Scene scene;
  const RayTracer tracer(scene);
  EXPECT_FALSE(tracer.range({0, 0, 0}, {1, 0, 0}, 100.0));
}

TEST(RayTracer, RefusesAMeshThatIsNotThere) {
  BoxScene world;
  world.addBox({1.0F, 1.0F, 1.0F}, at(4.0, 0.0, 0.0), world.addMaterial({1, 1, 1}));
  world.scene.models[0].visuals[0].mesh = 7;
  EXPECT_THROW(RayTracer tracer(world.scene), ConfigError);
  world.scene.models[0].visuals[0].mesh = 0;
  world.scene.meshes[0].triangles[3] = {0, 1, 8};
  EXPECT_THROW(RayTracer tracer(world.scene), ConfigError);
}

}  // namespace
}  // namespace frugal_nav::sim
