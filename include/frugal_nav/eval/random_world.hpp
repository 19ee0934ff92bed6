#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/eval/free_space.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::eval {

/// A furnished place with a task: from `start` to `goal`.
struct RandomWorld {
  std::string kind;  ///< "room", "corridor" or "bend"
  sim::Scene scene;
  std::vector<Solid> solids;  ///< the same things as outlines, overhangs too
  Pose2 start;
  Pose2 goal;
  double path_length_m = 0.0;  ///< shortest way of the disc that must fit
};

/// Draws a world from a seed. A disc of `disc_radius_m` fits all the way from start to goal; the robot's own
/// circumradius and a margin make that disc.
RandomWorld makeRandomWorld(std::uint64_t seed, double disc_radius_m);

}  // namespace frugal_nav::eval
