#pragma once

#include "furniture.hpp"
#include "random_paint.hpp"

#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/eval/free_space.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::eval {

/// Builds a painted, furnished, lit room with solid walls into a scene.
class CameraRoom {
 public:
  /// Keeps references to all three.
  CameraRoom(const std::vector<sim::Texture>& textures, Random& random, sim::Scene& scene)
      : textures_(textures), random_(random), scene_(scene) {}

  /// Floor, ceiling, walls, lamps; with two doorways across from each other at `door_x_m`, each to a closet.
  void build(const Eigen::AlignedBox2d& floor, std::optional<double> door_x_m);
  /// A partition across the room from one y to another; nothing when there is no room for one.
  void closeRow(double x_m, double from_y_m, double to_y_m);
  /// Furniture along the walls, outside of the lane between `right_m` and `left_m` up to `lane_end_m`, and
  /// not at the partition at `row_x_m`.
  void furnish(double right_m, double left_m, double lane_end_m, double row_x_m);
  /// A box, a bin or a stack of boxes that takes `width_m` across the room.
  void addObstacle(const Eigen::Vector2d& p, double width_m, double height_m);
  /// A square pillar up to the ceiling, painted as the walls are.
  void addPillar(const Eigen::Vector2d& p, double width_m);

  std::vector<Solid> solids;  ///< all that was built, overhangs too

 private:
  struct Span {
    double from_m;
    double to_m;
  };
  Paint paint() { return drawPaint(textures_, random_, scene_); }
  void put(const Furniture& piece, const Pose2& pose, const std::string& name, const Paint& look,
           const Eigen::Vector2d& face_m);
  void addSlab(const Eigen::AlignedBox2d& area, double bottom_m, double thickness_m, const Paint& look,
               const std::string& name);
  void addWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Span heights);
  void addSideWall(double y_m, double outward, std::optional<double> door_x_m);
  void addEndWall(double x_m, double outward);
  void addCloset(double x_m, double y_m, double outward);
  void addPictures(double y_m, double inward, std::optional<double> door_x_m);
  void addLamps();
  Furniture drawFurniture();

  const std::vector<sim::Texture>& textures_;
  Random& random_;
  sim::Scene& scene_;
  Eigen::AlignedBox2d floor_;
  std::optional<double> door_x_m_;
  double height_m_ = 2.6;
  Paint walls_;
  int number_ = 0;
};

}  // namespace frugal_nav::eval
