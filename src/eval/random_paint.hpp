#pragma once

#include <string>
#include <vector>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::eval {

/// A random look of a surface, and how it lies on the things that wear it.
struct Paint {
  int material = -1;      ///< index into Scene::materials
  double repeat_m = 1.0;  ///< length that its texture covers once
};

/// The images of a folder, shrunk to at most 512 pixels, in the order of their names. Throws ConfigError when
/// the folder holds none.
std::vector<sim::Texture> readTextures(const std::string& folder);

/// Adds a plain, printed (from `stock`) or computed material (noise, tiles, stripes, checks, speckles) to a
/// scene.
Paint drawPaint(const std::vector<sim::Texture>& stock, Random& random, sim::Scene& scene);

/// Lets a mesh of one of SDF's shapes wear a paint: texture coordinates in repeats, not in faces.
void wear(const Paint& paint, const Eigen::Vector2d& face_m, sim::Mesh& mesh);

}  // namespace frugal_nav::eval
