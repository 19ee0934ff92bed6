#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/robot/robot_model.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

/// Shapes that lie wholly below this height are floor, which touches the wheels and is no contact [m].
constexpr double kFloorHeight_m = 0.01;

/// A model near the robot: where the two come closest.
struct Proximity {
  int model = -1;  ///< index into Scene::models
  std::string link;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();        ///< on the model [m]
  Eigen::Vector3d normal_world = Eigen::Vector3d::UnitX();  ///< from the model to the robot
  double distance_m = 0.0;                                  ///< negative: the shapes overlap
};

/// The solid shapes of a scene and of the robot. The floor is left out: planes that face up, shapes wholly
/// below kFloorHeight_m, and the triangles of a mesh that are.
class ContactWorld {
 public:
  /// Throws ConfigError naming a model whose collision shape cannot be built. Keeps no reference to the
  /// scene.
  ContactWorld(const Scene& scene, const RobotModel& robot);
  ~ContactWorld();
  ContactWorld(const ContactWorld&) = delete;
  ContactWorld& operator=(const ContactWorld&) = delete;

  /// Reads a model's pose and those of its collision shapes again.
  void updateModel(const Scene& scene, int model);

  /// The models within a distance of the robot at a pose, in the order of their index, each with its nearest
  /// or deepest pair. Costs little where nothing can have come near since the last call.
  std::vector<Proximity> near(const Pose2& world_from_base, double within_m);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace frugal_nav::sim
