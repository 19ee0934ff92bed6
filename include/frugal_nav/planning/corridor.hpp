#pragma once

#include <vector>

#include <frugal_nav/common/geometry.hpp>

namespace frugal_nav {

/// A straight strip that starts at base_link.
struct Corridor {
  Eigen::Vector2d to_base;  ///< where it leads, in base_link [m]
  double half_width_m = 0.0;
  double beyond_m = 0.0;  ///< how far past its end it must be free: the body's front
};

/// Whether no obstacle (points in base_link) lies in the strip ahead.
bool isFree(const Corridor& corridor, const std::vector<Eigen::Vector2d>& obstacles_base);

}  // namespace frugal_nav
