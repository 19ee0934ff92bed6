#pragma once

#include <string>
#include <vector>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/eval/free_space.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::eval {

/// A box or an upright cylinder of a piece of furniture; what begins above kRobotHeight_m is an overhang.
struct Part {
  Solid outline;  ///< in the piece's frame
  double bottom_m = 0.0;
  double height_m = 1.0;
};

/// A piece of furniture: its parts, and the rectangle they fill.
struct Furniture {
  std::string kind;
  std::vector<Part> parts;
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();
  Eigen::Vector3f colour{0.6F, 0.6F, 0.6F};
};

/// Parts above this height cannot touch a robot 0.42 m high.
constexpr double kRobotHeight_m = 0.43;

// The pieces, their sizes drawn at random. Whatever a robot can touch crosses the scan plane at 0.18 m.
Furniture makeWall(double length_m);
Furniture makeTable(Random& random);
Furniture makeChair(Random& random);
Furniture makeCabinet(Random& random);
Furniture makeShelf(Random& random);
Furniture makeCarton(Random& random);
Furniture makeBin(Random& random);
Furniture makePillar(Random& random);

/// Puts a piece into a scene and its outlines into the list of solids.
void place(const Furniture& piece, const Pose2& world_from_piece, const std::string& name, sim::Scene& scene,
           std::vector<Solid>& solids);

}  // namespace frugal_nav::eval
