#pragma once

#include "lens.hpp"
#include "worker_pool.hpp"

#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/sim/lighting.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>

namespace frugal_nav::sim {

/// Light that reaches each pixel, row by row: three channels, as the illuminance [lx] that would make a white
/// surface look so. With depth, also the depth along the optical axis [m] (infinite for nothing) and the
/// cosine between the ray and the surface's normal.
struct LightImage {
  std::vector<Eigen::Vector3f> light_lx;
  std::vector<float> depth_m;
  std::vector<float> cos_incidence;
  std::vector<Eigen::Vector3f> smeared_lx;  ///< working memory of smearAlongMotion
};

/// What a camera renders with.
struct View {
  const RayTracer& tracer;
  const Lighting& lighting;
  const Lens& lens;
};

/// Averages the views from the given poses (of the optical frame) into `image`, whose memory is reused.
/// Depth, when wanted, is seen from the middle pose. The result does not depend on the number of threads.
void renderLight(const View& view, const std::vector<Eigen::Isometry3d>& world_from_optical, bool with_depth,
                 WorkerPool& pool, LightImage& image);

}  // namespace frugal_nav::sim
