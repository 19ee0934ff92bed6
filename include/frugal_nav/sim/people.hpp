#pragma once

#include <vector>

#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

/// Where a person is and how it moves at one time of the world.
struct PersonMotion {
  Pose2 world_from_person;  ///< between the feet (sitting: under the seat's middle), looking along x
  Eigen::Vector2d velocity_mps = Eigen::Vector2d::Zero();  ///< in the world's axes
  double walked_m = 0.0;                                   ///< since the start, over all rounds of the loop
};

/// A person's motion at a time of the world [s]: straight between waypoints at their times, the yaw turning
/// the short way. It waits at the first waypoint until start_delay_s and, unless `loop`, stays at the last;
/// a loop begins again at the first, as a Gazebo actor's script does.
/// Throws ConfigError naming a person without waypoints or with times that do not ascend.
PersonMotion personMotion(const Person& person, double time_s);

/// A person's body in a scene: rigid parts, which posePerson() moves.
struct PersonBody {
  int person = -1;  ///< index into Scene::people
  int model = -1;   ///< index into Scene::models

  /// Lengths the joints need [m]; the body's frame lies on the floor between the feet.
  double height_m = 0.0;
  double hip_height_m = 0.0;
  double hip_offset_m = 0.0;  ///< of each hip from the middle
  double thigh_m = 0.0;
  double shin_m = 0.0;  ///< knee to ankle
  double ankle_m = 0.0;
  double neck_height_m = 0.0;
  double shoulder_height_m = 0.0;
  double shoulder_offset_m = 0.0;
  double upper_arm_m = 0.0;

  /// Index into Model::visuals of each limb; left, right.
  int torso = -1;
  int head = -1;
  int upper_arm[2] = {-1, -1};
  int forearm[2] = {-1, -1};
  int thigh[2] = {-1, -1};
  int shin[2] = {-1, -1};
  int foot[2] = {-1, -1};
};

/// Height of the seat a sitting person needs [m].
constexpr double kSeatHeight_m = 0.45;

/// Adds the bodies of scene.people to the scene's models, meshes, materials and textures, posed at time 0.
/// A body follows from the person's `appearance` and posture alone. Throws ConfigError as personMotion().
std::vector<PersonBody> addPeople(Scene& scene);

/// Poses a body (its model and limbs) for a time of the world [s].
void posePerson(const PersonBody& body, double time_s, Scene& scene);

}  // namespace frugal_nav::sim
