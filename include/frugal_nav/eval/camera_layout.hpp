#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/eval/free_space.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::eval {

/// How far before a person the robot is to stop [m].
constexpr double kStandOff_m = 0.8;
/// Index into Scene::people of a layout.
constexpr int kGoalPerson = 0;
constexpr int kWalker = 1;

/// A person who walks once across the robot's way, from one doorway to the other.
struct Crossing {
  double x_m = 0.0;  ///< the line on which it walks, parallel to y
  double from_y_m = 0.0;
  double to_y_m = 0.0;
  double speed_mps = 0.5;
  double lead_m = 1.0;  ///< it steps into the robot's lane when the robot is this far before its line
};

/// One of the paper's trials: a furnished room, a person to go to, obstacles on the way.
struct CameraLayout {
  sim::Scene scene;              ///< people: the goal, and the walker when there is one; he waits
  std::vector<Solid> solids;     ///< walls, furniture and obstacles
  std::vector<Solid> obstacles;  ///< the obstacles alone
  Eigen::AlignedBox2d floor;     ///< between the walls [m]
  Pose2 start;                   ///< at the origin
  Eigen::Vector2d p_person{0.0, 0.0};
  Eigen::Vector2d p_stand_off{0.0, 0.0};
  double distance_m = 0.0;  ///< from start to stand-off point
  double gap_m = 0.0;       ///< narrowest place of the widest way
  std::string light;        ///< "daylight", "dim" or "tube"
  std::optional<Crossing> crossing;
};

/// Draws a layout from a seed. The head is in view at the start; an obstacle stands on the straight line;
/// the widest way past leaves 1.5 to 4 robot widths. `textures` are those of the package's folder `worlds`.
CameraLayout makeCameraLayout(std::uint64_t seed, double robot_width_m,
                              const std::vector<sim::Texture>& textures);

}  // namespace frugal_nav::eval
