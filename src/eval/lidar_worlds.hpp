#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <frugal_nav/eval/random_world.hpp>
#include <frugal_nav/sim/simulator.hpp>

namespace frugal_nav::eval {

/// A model that goes to and fro between two places, whatever stands in its way.
struct Mover {
  int model = -1;
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  double speed_mps = 0.5;
  double begins_s = 0.0;  ///< how far into its course it is at the start

  /// Where it is at a time since the start.
  Eigen::Vector2d at(double time_s) const;
};

/// A world, and what moves in it besides its people.
struct LidarWorld {
  RandomWorld place;
  std::vector<Mover> movers;
};

/// Two rooms and an open doorway of `door_m` between them, to be driven through.
LidarWorld makeDoorwayWorld(std::uint64_t seed, double door_m);
/// A hall in which two people and a cylinder cross the way at 0.3 to 1.0 m/s, to and fro.
LidarWorld makeMovingWorld(std::uint64_t seed);
/// A room with a thing whose surface is `gap_m` beside the goal.
LidarWorld makeNearTargetWorld(std::uint64_t seed, double gap_m);

/// Puts the movers where they are at the simulator's time.
void moveAll(const std::vector<Mover>& movers, sim::Simulator& simulator);

}  // namespace frugal_nav::eval
