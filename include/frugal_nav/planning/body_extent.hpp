#pragma once

namespace frugal_nav {

/// What planning has to know of the robot's body; from its URDF, about base_link.
struct BodyExtent {
  double half_width_m = 0.0;    ///< half extent across the driving direction
  double circumradius_m = 0.0;  ///< farthest point of the footprint: what a turn on the spot sweeps
};

}  // namespace frugal_nav
