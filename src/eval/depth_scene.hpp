#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/eval/visual_drive.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::eval {

/// A room with a thing to be measured, and the way that leads to the place from which it is.
struct DepthScene {
  sim::Scene scene;
  std::string object;  ///< what kind of thing
  std::string light;   ///< "daylight", "dim" or "tube"
  int object_model = -1;
  Pose2 start;
  std::vector<DriveLeg> legs;  ///< from start to the origin, as around something, so that there is parallax
};

/// Draws a scene whose object stands `distance_m` ahead of the camera at the end of the drive, within the
/// view's middle half. `textures` are the prints that its surfaces may wear.
DepthScene makeDepthScene(std::uint64_t seed, double distance_m, double camera_x_m,
                          const std::vector<sim::Texture>& textures);

}  // namespace frugal_nav::eval
