#pragma once

#include <optional>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/planning/active_window.hpp>

namespace frugal_nav {

/// A place between two obstacles, as wide as the returns say, not as the grid's cells do.
struct TightPassage {
  Eigen::Vector2d middle_odom;
  Eigen::Vector2d along_odom;  ///< unit vector through it, to either side
  double width_m = 0.0;
};

/// The passage at a place: between the obstacle nearest to it and the nearest on the other side, both within
/// `reach_m`; nothing where one side is open.
std::optional<TightPassage> passageAt(const Eigen::Vector2d& p_odom,
                                      const std::vector<WindowPoint>& obstacles, double reach_m);

/// A polyline led through a passage: straight through its middle from `approach_m` before it to as far
/// behind. Its first and its last corner stay.
std::vector<Eigen::Vector2d> leadThrough(const std::vector<Eigen::Vector2d>& line,
                                         const TightPassage& passage, double approach_m);

}  // namespace frugal_nav
