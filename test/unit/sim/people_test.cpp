#include <algorithm>

#include <gtest/gtest.h>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/sim/people.hpp>

namespace frugal_nav::sim {
namespace {

Person stander(std::uint64_t appearance) {
  Person person;
  person.name = "person";
  person.appearance = appearance;
  person.waypoints.push_back({0.0, Pose2{1.0, 2.0, 0.5}});
  return person;
}

/// 4 m east in 4 s, a turn on the spot for 1 s, 2 m north in 4 s.
Person walker() {
  Person person;
  person.name = "walker";
  person.posture = Posture::kWalking;
  person.appearance = 7;
  person.waypoints = {{0.0, {0, 0, 0}}, {4.0, {4, 0, 0}}, {5.0, {4, 0, M_PI / 2}}, {9.0, {4, 2, M_PI / 2}}};
  return person;
}

struct Posed {
  Scene scene;
  PersonBody body;
};

Posed bodyOf(const Person& person) {
  Posed posed;
  posed.scene.people.push_back(person);
  posed.body = addPeople(posed.scene).front();
  return posed;
}

/// Bounds of a body's parts in the world; of one part when it is named.
Eigen::AlignedBox3d bounds(const Posed& posed, int part = -1) {
  const Model& model = posed.scene.models[static_cast<std::size_t>(posed.body.model)];
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < model.visuals.size(); ++i) {
    if (part >= 0 && static_cast<int>(i) != part) continue;
    const Eigen::Isometry3d pose = model.world_from_model * model.visuals[i].model_from_visual;
    for (const Eigen::Vector3f& vertex :
         posed.scene.meshes[static_cast<std::size_t>(model.visuals[i].mesh)].vertices)
      box.extend(pose * vertex.cast<double>());
  }
  return box;
}

TEST(People, StandOnTheFloorAsTallAsTheirBuild) {
  for (std::uint64_t seed = 500000; seed < 500030; ++seed) {
    const Posed posed = bodyOf(stander(seed));
    // The standing hips are 2 mm lower than a straight leg's, and the sole is a rounded loft.
    EXPECT_NEAR(bounds(posed).min().z(), 0.0, 0.01) << seed;
    EXPECT_GE(posed.body.height_m, 1.5);
    EXPECT_LE(posed.body.height_m, 1.95);
    // Hair stands up to 4 cm (the fullest is 42 mm), never more.
    EXPECT_GT(bounds(posed).max().z(), posed.body.height_m - 0.01) << seed;
    EXPECT_LT(bounds(posed).max().z(), posed.body.height_m + 0.05) << seed;
    const Eigen::AlignedBox3d head = bounds(posed, posed.body.head);
    EXPECT_NEAR(head.center().head<2>().x(), 1.0, 0.1) << seed;
  }
}

TEST(People, AreShapedLikePeople) {
  for (std::uint64_t seed = 500000; seed < 500030; ++seed) {
    const Posed posed = bodyOf(stander(seed));
    const Eigen::Vector3d size = bounds(posed).sizes();
    EXPECT_LT(std::max(size.x(), size.y()), 0.95) << seed;
    EXPECT_GT(std::min(size.x(), size.y()), 0.25) << seed;
    std::size_t triangles = 0;
    for (const Visual& visual : posed.scene.models.front().visuals)
      triangles += posed.scene.meshes[static_cast<std::size_t>(visual.mesh)].triangles.size();
    EXPECT_LT(triangles, 6000U);
  }
}

TEST(People, SitAtSeatHeightWithTheirFeetOnTheFloor) {
  for (std::uint64_t seed = 500000; seed < 500030; ++seed) {
    Person person = stander(seed);
    person.posture = Posture::kSitting;
    person.waypoints.front().world_from_person = Pose2{};
    const Posed posed = bodyOf(person);
    EXPECT_NEAR(bounds(posed, posed.body.foot[0]).min().z(), 0.0, 0.01) << seed;
    // The trunk rests on the seat: it sinks in by the cloth's and the cushion's few centimetres.
    EXPECT_NEAR(bounds(posed, posed.body.torso).min().z(), kSeatHeight_m, 0.06) << seed;
    EXPECT_LT(bounds(posed).max().z(), posed.body.height_m - 0.15) << seed;
    EXPECT_GT(bounds(posed, posed.body.foot[0]).min().x(), 0.1) << seed;
  }
}

TEST(People, WalkersLegsMoveAndTheirFeetStayNearTheFloor) {
  Posed posed = bodyOf(walker());
  double widest = 0.0;
  double narrowest = 10.0;
  for (double time = 0.0; time < 4.0; time += 0.02) {
    posePerson(posed.body, time, posed.scene);
    const double left = bounds(posed, posed.body.foot[0]).center().x();
    const double right = bounds(posed, posed.body.foot[1]).center().x();
    widest = std::max(widest, std::abs(left - right));
    narrowest = std::min(narrowest, std::abs(left - right));
    // A toe that leaves the floor points down: up to its length from the ankle (0.2 m) times sin(0.5) lower
    // than the ankle's lift; the leg's slack is 1 %.
    EXPECT_NEAR(bounds(posed).min().z(), 0.0, 0.03) << time;
  }
  EXPECT_GT(widest, 0.4);
  EXPECT_LT(narrowest, 0.05);
}

TEST(People, AStandingFootDoesNotSlide) {
  Posed posed = bodyOf(walker());
  // The left foot is halfway through its stand at no distance: for a tenth of a metre it must stay.
  const double before = bounds(posed, posed.body.foot[0]).center().x();
  posePerson(posed.body, 0.1, posed.scene);
  EXPECT_NEAR(bounds(posed, posed.body.foot[0]).center().x(), before, 1e-6);
}

TEST(People, FollowWaypointsInTime) {
  const Person person = walker();
  const PersonMotion half = personMotion(person, 2.0);
  EXPECT_NEAR(half.world_from_person.x_m, 2.0, 1e-12);
  EXPECT_NEAR(half.velocity_mps.x(), 1.0, 1e-12);
  EXPECT_NEAR(half.walked_m, 2.0, 1e-12);
  const PersonMotion turning = personMotion(person, 4.5);
  EXPECT_NEAR(turning.world_from_person.yaw_rad, M_PI / 4, 1e-12);
  EXPECT_NEAR(turning.velocity_mps.norm(), 0.0, 1e-12);
  const PersonMotion north = personMotion(person, 7.0);
  EXPECT_NEAR(north.world_from_person.y_m, 1.0, 1e-12);
  EXPECT_NEAR(north.velocity_mps.y(), 0.5, 1e-12);
}

TEST(People, LoopFromTheFirstWaypointAgain) {
  Person person = walker();
  const PersonMotion again = personMotion(person, 9.0 + 9.0 + 1.0);
  EXPECT_NEAR(again.world_from_person.x_m, 1.0, 1e-9);
  EXPECT_NEAR(again.walked_m, 2 * 6.0 + 1.0, 1e-9);
  person.loop = false;
  const PersonMotion last = personMotion(person, 100.0);
  EXPECT_NEAR(last.world_from_person.y_m, 2.0, 1e-12);
  EXPECT_EQ(last.velocity_mps.norm(), 0.0);
}

TEST(People, WaitForTheirStart) {
  Person person = walker();
  person.start_delay_s = 3.0;
  EXPECT_EQ(personMotion(person, 2.9).world_from_person.x_m, 0.0);
  EXPECT_EQ(personMotion(person, 2.9).velocity_mps.norm(), 0.0);
  EXPECT_NEAR(personMotion(person, 4.0).world_from_person.x_m, 1.0, 1e-12);
}

TEST(People, MotionHasNoJumpsButTheLoop) {
  const Person person = walker();
  for (double time = 0.0; time < 8.98; time += 0.01) {
    const Pose2 a = personMotion(person, time).world_from_person;
    const Pose2 b = personMotion(person, time + 0.01).world_from_person;
    EXPECT_LT(distance(a, b), 0.0101) << time;  // at most 1 m/s
  }
}

std::vector<std::uint8_t> headOf(const Posed& posed) { return posed.scene.textures.front().rgb; }

TEST(People, SameAppearanceSameBytes) {
  const Posed a = bodyOf(stander(500123));
  const Posed b = bodyOf(stander(500123));
  EXPECT_EQ(headOf(a), headOf(b));
  ASSERT_EQ(a.scene.meshes.size(), b.scene.meshes.size());
  for (std::size_t i = 0; i < a.scene.meshes.size(); ++i)
    EXPECT_EQ(a.scene.meshes[i].vertices, b.scene.meshes[i].vertices);
}

TEST(People, DifferentAppearanceDiffers) {
  const Posed a = bodyOf(stander(500123));
  const Posed b = bodyOf(stander(500124));
  EXPECT_NE(headOf(a), headOf(b));
  EXPECT_NE(a.body.height_m, b.body.height_m);
}

TEST(People, NormalsPointOutward) {
  const Posed posed = bodyOf(stander(500001));
  for (const Mesh& mesh : posed.scene.meshes) {
    std::size_t against = 0;
    for (const Eigen::Vector3i& triangle : mesh.triangles) {
      const auto at = [&](int i) { return mesh.vertices[static_cast<std::size_t>(triangle[i])]; };
      const Eigen::Vector3f face = (at(1) - at(0)).cross(at(2) - at(0));
      if (face.dot(mesh.normals[static_cast<std::size_t>(triangle[0])]) < 0.0F) ++against;
    }
    // Ledges (a hem, a cuff) have normals smoothed over their edge.
    EXPECT_LT(against, mesh.triangles.size() / 20 + 1);
  }
}

TEST(People, LegsAreSolidFromTheFloorUp) {
  for (const Posture posture : {Posture::kStanding, Posture::kSitting, Posture::kWalking}) {
    Person person = stander(500002);
    person.posture = posture;
    const Posed posed = bodyOf(person);
    const auto& collisions = posed.scene.models.front().collisions;
    EXPECT_TRUE(std::any_of(collisions.begin(), collisions.end(), [](const Collision& solid) {
      return solid.kind == Collision::Kind::kCylinder &&
             std::abs(solid.model_from_collision.translation().z() - 0.5 * solid.size_m.z()) < 1e-9;
    }));
  }
}

TEST(People, RefuseAWayThatCannotBeWalked) {
  Scene scene;
  scene.people.push_back(stander(1));
  scene.people.front().waypoints.clear();
  EXPECT_THROW(addPeople(scene), ConfigError);
  Person backward = walker();
  backward.waypoints[2].time_s = 1.0;
  EXPECT_THROW(personMotion(backward, 0.0), ConfigError);
}

}  // namespace
}  // namespace frugal_nav::sim
