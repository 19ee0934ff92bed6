#include "lidar_worlds.hpp"

#include "furniture.hpp"

#include <algorithm>
#include <cmath>

namespace frugal_nav::eval {
namespace {

constexpr double kWallThickness_m = 0.1;
constexpr double kTurn_s = 1.0;  // a person turns at the end of its way

void addWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, RandomWorld& world) {
  const Eigen::Vector2d way = to - from;
  const Eigen::Vector2d middle = 0.5 * (from + to);
  place(makeWall(way.norm()), {middle.x(), middle.y(), std::atan2(way.y(), way.x())},
        "wall_" + std::to_string(world.solids.size()), world.scene, world.solids);
}

/// Four walls around a floor from the origin on.
RandomWorld makeRoom(const std::string& kind, double length_m, double width_m) {
  RandomWorld world;
  world.kind = world.scene.name = kind;
  const double out = 0.5 * kWallThickness_m;
  addWall({-kWallThickness_m, -out}, {length_m + kWallThickness_m, -out}, world);
  addWall({-kWallThickness_m, width_m + out}, {length_m + kWallThickness_m, width_m + out}, world);
  addWall({-out, 0.0}, {-out, width_m}, world);
  addWall({length_m + out, 0.0}, {length_m + out, width_m}, world);
  return world;
}

Pose2 drawPose(const Eigen::AlignedBox2d& area, Random& random) {
  const double x = random.uniform(area.min().x(), area.max().x());
  const double y = random.uniform(area.min().y(), area.max().y());
  return {x, y, random.uniform(-M_PI, M_PI)};
}

sim::Person crossingPerson(int number, const Mover& course, Random& random) {
  const Eigen::Vector2d way = course.to - course.from;
  const double there = std::atan2(way.y(), way.x());
  const double walk_s = way.norm() / course.speed_mps;
  sim::Person person;
  person.name = "walker_" + std::to_string(number);
  person.posture = sim::Posture::kWalking;
  person.appearance = static_cast<std::uint64_t>(random.integer(1, 1000000));
  const auto add = [&person](double time_s, const Eigen::Vector2d& p, double yaw) {
    person.waypoints.push_back({time_s, {p.x(), p.y(), wrapAngle(yaw)}});
  };
  add(0.0, course.from, there);
  add(walk_s, course.to, there);
  add(walk_s + kTurn_s, course.to, there + M_PI);
  add(2.0 * walk_s + kTurn_s, course.from, there + M_PI);
  add(2.0 * (walk_s + kTurn_s), course.from, there);
  return person;
}

/// A course across the hall at a place along it.
Mover drawCrossing(double x_m, double width_m, Random& random) {
  constexpr double kAside_m = 0.7;
  Mover course;
  course.from = {x_m + random.uniform(-0.5, 0.5), kAside_m};
  course.to = {x_m + random.uniform(-0.5, 0.5), width_m - kAside_m};
  if (random.chance(0.5)) std::swap(course.from, course.to);
  course.speed_mps = random.uniform(0.3, 1.0);
  course.begins_s = random.uniform(0.0, 10.0);
  return course;
}

}  // namespace

Eigen::Vector2d Mover::at(double time_s) const {
  const double walk_s = (to - from).norm() / speed_mps;
  const double phase = std::fmod((time_s + begins_s) / walk_s, 2.0);
  return from + (phase < 1.0 ? phase : 2.0 - phase) * (to - from);
}

LidarWorld makeDoorwayWorld(std::uint64_t seed, double door_m) {
  Random random(seed, "doorway_world");
  const double length = random.uniform(5.0, 7.0);
  const double width = random.uniform(3.0, 5.0);
  const double wall_x = 0.5 * length;
  const double door_y = random.uniform(0.8, width - 0.8);
  LidarWorld world{makeRoom("doorway", length, width), {}};
  addWall({wall_x, 0.0}, {wall_x, door_y - 0.5 * door_m}, world.place);
  addWall({wall_x, door_y + 0.5 * door_m}, {wall_x, width}, world.place);
  constexpr double kAway_m = 0.6;
  const Eigen::Vector2d low(kAway_m, kAway_m);
  const Eigen::Vector2d room(wall_x - 2.0 * kAway_m, width - 2.0 * kAway_m);
  const Eigen::Vector2d beyond(wall_x, 0.0);
  world.place.start = drawPose({low, low + room}, random);
  world.place.goal = drawPose({low + beyond, low + beyond + room}, random);
  const Eigen::Vector2d door(wall_x, door_y);
  world.place.path_length_m =
      (door - world.place.start.position()).norm() + (world.place.goal.position() - door).norm();
  return world;
}

LidarWorld makeMovingWorld(std::uint64_t seed) {
  Random random(seed, "moving_world");
  const double width = random.uniform(4.0, 5.5);
  LidarWorld world{makeRoom("moving", 9.0, width), {}};
  RandomWorld& place_in = world.place;
  place_in.start = drawPose({Eigen::Vector2d(0.6, 0.8), Eigen::Vector2d(1.4, width - 0.8)}, random);
  place_in.goal = drawPose({Eigen::Vector2d(7.6, 0.8), Eigen::Vector2d(8.4, width - 0.8)}, random);
  place_in.path_length_m = distance(place_in.start, place_in.goal);
  const int first = random.integer(0, 2);
  for (int i = 0; i < 3; ++i) {
    const double x = 2.8 + 1.8 * i;
    Mover course = drawCrossing(x, width, random);
    if (i == first) {
      course.model = static_cast<int>(place_in.scene.models.size());
      place(makeBin(random), {course.from.x(), course.from.y(), 0.0}, "mover", place_in.scene,
            place_in.solids);
      place_in.solids.pop_back();  // it does not stay there
      world.movers.push_back(course);
    } else {
      place_in.scene.people.push_back(crossingPerson(i, course, random));
    }
  }
  return world;
}

LidarWorld makeNearTargetWorld(std::uint64_t seed, double gap_m) {
  Random random(seed, "near_target_world");
  const double length = random.uniform(5.0, 7.0);
  const double width = random.uniform(4.0, 5.0);
  LidarWorld world{makeRoom("near_target", length, width), {}};
  RandomWorld& place_in = world.place;
  place_in.start = drawPose({Eigen::Vector2d(0.6, 0.8), Eigen::Vector2d(1.2, width - 0.8)}, random);
  place_in.goal =
      drawPose({Eigen::Vector2d(length - 2.0, 1.4), Eigen::Vector2d(length - 1.4, width - 1.4)}, random);
  place_in.path_length_m = distance(place_in.start, place_in.goal);
  const Furniture thing = random.chance(0.5) ? makePillar(random) : makeCarton(random);
  const double away = random.uniform(-M_PI, M_PI);
  // A box is turned toward the goal, so that its face is what lies nearest.
  const double reach = gap_m + 0.5 * thing.size_m.x();
  place(thing, {place_in.goal.x_m + reach * std::cos(away), place_in.goal.y_m + reach * std::sin(away), away},
        "thing", place_in.scene, place_in.solids);
  return world;
}

void moveAll(const std::vector<Mover>& movers, sim::Simulator& simulator) {
  const double time_s = toSeconds(simulator.stamp() - sim::kStartTime);
  for (const Mover& mover : movers) {
    const Eigen::Vector2d p = mover.at(time_s);
    simulator.moveModel(mover.model, toIsometry(Pose2{p.x(), p.y(), 0.0}));
  }
}

}  // namespace frugal_nav::eval
