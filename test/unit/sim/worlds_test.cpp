// The worlds that come with the package.
#include <filesystem>

#include <gtest/gtest.h>

#include <frugal_nav/sim/people.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>
#include <frugal_nav/sim/sdf_world.hpp>

namespace frugal_nav::sim {
namespace {

const std::string kWorlds = FRUGAL_NAV_SOURCE_DIR "/worlds/";

Scene load(const std::string& name) {
  const LoadedWorld world = loadWorld(kWorlds + name + ".world", ResourcePath());
  for (const std::string& warning : world.warnings) ADD_FAILURE() << name << ": " << warning;
  EXPECT_TRUE(world.is_complete) << name;
  return world.scene;
}

/// Distance to the nearest thing around a place, at the heights of a low robot [m].
double clearance(const RayTracer& tracer, double x, double y) {
  double nearest = 2.0;
  constexpr int kBeams = 120;
  for (int i = 0; i < kBeams; ++i) {
    const double angle = 2.0 * M_PI * i / kBeams;
    for (const double z : {0.05, 0.18, 0.40}) {
      const auto range = tracer.range({x, y, z}, {std::cos(angle), std::sin(angle), 0.0}, nearest);
      nearest = std::min(nearest, range.value_or(nearest));
    }
  }
  return nearest;
}

class Worlds : public testing::TestWithParam<const char*> {};

TEST_P(Worlds, LoadWithoutAWarning) {
  Scene scene = load(GetParam());
  addPeople(scene);
  std::size_t triangles = 0;
  for (const Model& model : scene.models) {
    for (const Visual& visual : model.visuals)
      triangles += scene.meshes[static_cast<std::size_t>(visual.mesh)].triangles.size();
  }
  EXPECT_LT(triangles, 120000U);
  EXPECT_GE(scene.textures.size(), 8U);
  EXPECT_FALSE(scene.lights.empty());
}

INSTANTIATE_TEST_SUITE_P(All, Worlds, testing::Values("lab", "lab_people", "corridor", "empty"),
                         [](const auto& name) { return std::string(name.param); });

TEST(LabWorld, StartAndGoalAreFreeAndTheWayBetweenIsNot) {
  Scene scene = load("lab");
  addPeople(scene);
  const RayTracer tracer(scene);
  const Eigen::Vector2d start(-4.0, -2.4);  // as the world file's comment says
  const Eigen::Vector2d goal(3.9, 1.9);
  EXPECT_GT(clearance(tracer, start.x(), start.y()), 0.5);
  EXPECT_GT(clearance(tracer, goal.x(), goal.y()), 0.5);
  EXPECT_GT((goal - start).norm(), 6.0);
  int obstacles = 0;
  bool was_blocked = false;
  constexpr double kHalfWidth_m = 0.125;
  for (double share = 0.0; share < 1.0; share += 0.005) {
    const Eigen::Vector2d at = start + share * (goal - start);
    const bool blocked = clearance(tracer, at.x(), at.y()) < kHalfWidth_m;
    if (blocked && !was_blocked) ++obstacles;
    was_blocked = blocked;
  }
  EXPECT_GE(obstacles, 3);
}

TEST(LabWorld, HasOneStandingAndOneSittingPersonAndNobodyWalks) {
  const Scene scene = load("lab");
  ASSERT_EQ(scene.people.size(), 2U);
  EXPECT_EQ(scene.people[0].posture, Posture::kStanding);
  EXPECT_EQ(scene.people[1].posture, Posture::kSitting);
}

TEST(LabWorld, WalkersKeepClearOfTheFurniture) {
  const Scene walking = load("lab_people");
  Scene still = load("lab");
  addPeople(still);
  const RayTracer tracer(still);
  int walkers = 0;
  for (const Person& person : walking.people) {
    if (person.posture != Posture::kWalking) continue;
    ++walkers;
    EXPECT_TRUE(person.loop);
    EXPECT_LT(distance(person.waypoints.front().world_from_person, person.waypoints.back().world_from_person),
              1e-6);
    for (double time = 0.0; time < person.waypoints.back().time_s; time += 0.1) {
      const Pose2 pose = personMotion(person, time).world_from_person;
      EXPECT_GT(clearance(tracer, pose.x_m, pose.y_m), 0.3) << person.name << " at " << time << " s";
    }
  }
  EXPECT_EQ(walkers, 2);
}

TEST(WorldFiles, AreSmall) {
  for (const auto& file : std::filesystem::recursive_directory_iterator(kWorlds)) {
    if (!file.is_regular_file()) continue;
    EXPECT_LT(file.file_size(), 200000U) << file.path();
  }
}

}  // namespace
}  // namespace frugal_nav::sim
