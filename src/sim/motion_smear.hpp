#pragma once

#include "lens.hpp"
#include "renderer.hpp"
#include "worker_pool.hpp"

#include <vector>

#include <Eigen/Geometry>

namespace frugal_nav::sim {

/// Joins the instants of a blurred image, which stand beside each other as ghosts, into one smear: every
/// pixel is averaged along its own motion over the spacing of two instants. Needs the depth of the image.
void smearAlongMotion(const Lens& lens, const std::vector<Eigen::Isometry3d>& world_from_optical,
                      WorkerPool& pool, LightImage& image);

}  // namespace frugal_nav::sim
