#pragma once

#include <algorithm>
#include <cmath>

namespace frugal_nav {

/// What planning has to know of the robot's body; from its URDF, about base_link.
struct BodyExtent {
  double half_width_m = 0.0;    ///< half extent across the driving direction
  double circumradius_m = 0.0;  ///< farthest point of the footprint: what a turn on the spot sweeps

  /// How far the rectangle with these two reaches ahead and behind [m].
  double front_m() const {
    return std::sqrt(std::max(circumradius_m * circumradius_m - half_width_m * half_width_m, 0.0));
  }
};

}  // namespace frugal_nav
