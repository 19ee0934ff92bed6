#include <cmath>

#include <gtest/gtest.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/sim/contact_world.hpp>

namespace frugal_nav::sim {
namespace {

constexpr double kMillimetre = 0.001;

/// A box of 0.4 m x 0.3 m, 0.1 m high, 2 cm above the floor, on a wheel that touches it.
RobotModel boxRobot() {
  RobotModel robot;
  robot.name = "box";
  RobotShape body{"body", BoxShape{{0.4, 0.3, 0.1}}, Eigen::Isometry3d::Identity(), {}};
  body.base_from_shape.translation().z() = 0.07;
  RobotShape wheel{"wheel", CylinderShape{0.03, 0.02}, Eigen::Isometry3d::Identity(), {}};
  wheel.base_from_shape.linear() = Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitX()).toRotationMatrix();
  wheel.base_from_shape.translation().z() = 0.03;
  robot.collisions = {body, wheel};
  return robot;
}

Model solid(const std::string& name, Collision::Kind kind, const Eigen::Vector3d& size_m,
            const Eigen::Vector3d& position_m) {
  Model model;
  model.name = name;
  model.world_from_model.translation() = position_m;
  Collision collision;
  collision.kind = kind;
  collision.size_m = size_m;
  model.collisions.push_back(collision);
  return model;
}

/// A wall as a mesh: two triangles in the plane x = 0, with a floor of two more below the robot.
Scene meshScene(double x_m) {
  Scene scene;
  Mesh mesh;
  mesh.vertices = {{0, -1, 0},  {0, 1, 0},  {0, 1, 1}, {0, -1, 1},
                   {-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  scene.meshes.push_back(mesh);
  scene.models.push_back(solid("wall", Collision::Kind::kMesh, Eigen::Vector3d::Ones(), {x_m, 0, 0}));
  scene.models[0].collisions[0].mesh = 0;
  return scene;
}

/// The distance of the nearest model with the robot at the origin, for a scene of one model.
double distanceTo(const Scene& scene, double x_m = 0.0) {
  ContactWorld world(scene, boxRobot());
  const std::vector<Proximity> found = world.near({x_m, 0.0, 0.0}, 0.05);
  return found.empty() ? 1.0 : found.front().distance_m;
}

Scene sceneOf(const Model& model) {
  Scene scene;
  scene.models.push_back(model);
  return scene;
}

struct Shape {
  const char* name;
  Collision::Kind kind;
  Eigen::Vector3d size_m;
  double reach_m;  // of the shape from its centre toward the robot
};

class ShapeContact : public testing::TestWithParam<Shape> {};

// The robot's front lies at x = 0.2. Half a millimetre is left for Bullet's rounding.
TEST_P(ShapeContact, ToldToTheMillimetre) {
  const Shape& shape = GetParam();
  for (const double gap_m : {kMillimetre, -kMillimetre, 5.0 * kMillimetre, -5.0 * kMillimetre}) {
    const Eigen::Vector3d position_m(0.2 + shape.reach_m + gap_m, 0.02, 0.08);
    EXPECT_NEAR(distanceTo(sceneOf(solid("it", shape.kind, shape.size_m, position_m))), gap_m,
                0.5 * kMillimetre);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, ShapeContact,
    testing::Values(Shape{"box", Collision::Kind::kBox, {0.5, 0.5, 1.0}, 0.25},
                    Shape{"cylinder", Collision::Kind::kCylinder, {0.075, 0.075, 1.0}, 0.075},
                    Shape{"sphere", Collision::Kind::kSphere, {0.2, 0.2, 0.2}, 0.2},
                    Shape{"plane", Collision::Kind::kPlane, {-1.0, 0.0, 0.0}, 0.0}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(ContactWorld, MeshWallIsToldToTheMillimetreAndItsFloorIsNone) {
  EXPECT_NEAR(distanceTo(meshScene(0.2 + kMillimetre)), kMillimetre, 0.5 * kMillimetre);
  EXPECT_NEAR(distanceTo(meshScene(0.2 - kMillimetre)), -kMillimetre, 0.5 * kMillimetre);
  EXPECT_EQ(distanceTo(meshScene(3.0)), 1.0);
}

TEST(ContactWorld, MillimetresHoldFarFromTheOrigin) {
  const Model far = solid("it", Collision::Kind::kBox, {0.5, 0.5, 1.0}, {60.45 + kMillimetre, 0, 0.5});
  EXPECT_NEAR(distanceTo(sceneOf(far), 60.0), kMillimetre, 0.5 * kMillimetre);
}

TEST(ContactWorld, FloorsAreNoContact) {
  EXPECT_EQ(distanceTo(sceneOf(solid("ground", Collision::Kind::kPlane, {0, 0, 1}, {0, 0, 0}))), 1.0);
  EXPECT_EQ(distanceTo(sceneOf(solid("slab", Collision::Kind::kBox, {10, 10, 1}, {0, 0, -0.5}))), 1.0);
  EXPECT_EQ(distanceTo(sceneOf(solid("carpet", Collision::Kind::kBox, {1, 1, 0.008}, {0, 0, 0.004}))), 1.0);
}

TEST(ContactWorld, WhatHangsAboveTheRobotIsNoContact) {
  EXPECT_EQ(distanceTo(sceneOf(solid("table", Collision::Kind::kBox, {1, 1, 0.04}, {0, 0, 0.7}))), 1.0);
}

TEST(ContactWorld, NamesTheDeepestLinkAndTheWayOut) {
  ContactWorld world(sceneOf(solid("post", Collision::Kind::kCylinder, {0.1, 0.1, 1.0}, {0.29, 0, 0.5})),
                     boxRobot());
  const std::vector<Proximity> found = world.near({}, 0.05);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].model, 0);
  EXPECT_EQ(found[0].link, "body");
  EXPECT_NEAR(found[0].normal_world.x(), -1.0, 1e-3);
  EXPECT_NEAR(found[0].p_world.x(), 0.19, kMillimetre);
}

TEST(ContactWorld, FollowsAModelThatMovesAfterADistantSearch) {
  Scene scene = sceneOf(solid("ball", Collision::Kind::kSphere, {0.1, 0.1, 0.1}, {3, 0, 0.1}));
  ContactWorld world(scene, boxRobot());
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(world.near({}, 0.005).empty());
  scene.models[0].world_from_model.translation().x() = 0.295;
  world.updateModel(scene, 0);
  EXPECT_EQ(world.near({}, 0.005).size(), 1U);
}

// The search is skipped where nothing can have come near: on a random walk among posts each answer must equal
// that of a world that has never been asked before.
TEST(ContactWorld, SkippedSearchesNeverMissATouch) {
  Random random(500001);
  Scene scene;
  for (int i = 0; i < 12; ++i) {
    scene.models.push_back(solid("post", Collision::Kind::kCylinder, {0.075, 0.075, 1.0},
                                 {random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5), 0.5}));
  }
  ContactWorld world(scene, boxRobot());
  Pose2 pose;
  int touches = 0;
  for (int i = 0; i < 1500; ++i) {
    pose = pose * Pose2{random.uniform(-0.02, 0.03), 0.0, random.uniform(-0.15, 0.15)};
    if (pose.position().norm() > 1.5) pose = {};
    if (i % 7 == 0) {
      scene.models[0].world_from_model.translation().head<2>() +=
          Eigen::Vector2d(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05));
      world.updateModel(scene, 0);
    }
    const std::vector<Proximity> found = world.near(pose, 0.005);
    const std::vector<Proximity> expected = ContactWorld(scene, boxRobot()).near(pose, 0.005);
    ASSERT_EQ(found.size(), expected.size()) << "step " << i;
    touches += expected.empty() ? 0 : 1;
  }
  EXPECT_GT(touches, 20);
}

TEST(ContactWorld, NamesAModelWithABadShape) {
  const Scene scene = sceneOf(solid("broken_box", Collision::Kind::kBox, {0, 1, 1}, {0, 0, 0}));
  try {
    ContactWorld world(scene, boxRobot());
    FAIL() << "expected a ConfigError";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("broken_box"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace frugal_nav::sim
