#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <frugal_nav/common/geometry.hpp>

namespace frugal_nav::eval {

/// The outline of a solid thing on the floor: a rectangle or, when `radius_m` is set, a disc.
struct Solid {
  Pose2 world_from_solid;
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();
  double radius_m = 0.0;
  bool overhang = false;  ///< above the robot: it passes below

  double distanceTo(const Eigen::Vector2d& p_world) const;  ///< [m]; 0 inside
  /// Corners, or points on the circle, counter-clockwise in the world.
  Polygon2 outline() const;
};

/// Where a disc fits between solid things: a grid over a rectangle of the floor.
class FreeSpace {
 public:
  /// A cell is free when a disc about its centre touches nothing; outside of the rectangle nothing is.
  FreeSpace(const Eigen::AlignedBox2d& bounds, const std::vector<Solid>& solids, double disc_radius_m);

  bool isFree(const Eigen::Vector2d& p) const;
  /// Length of the shortest 8-connected way between two free points [m]; nullopt when there is none.
  std::optional<double> pathLength(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;

 private:
  static constexpr double kCell_m = 0.05;
  int indexOf(const Eigen::Vector2d& p) const;  // -1 outside

  Eigen::AlignedBox2d bounds_;
  int width_ = 0;
  int height_ = 0;
  std::vector<char> free_;
};

}  // namespace frugal_nav::eval
