#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include <frugal_nav/odometry/visual_geometry.hpp>

namespace frugal_nav {

/// Rays to the features of one image, by feature id.
using RayMap = std::map<std::int64_t, Ray2>;

/// Rays of the same features in two images.
struct SharedRays {
  std::vector<std::int64_t> ids;
  std::vector<Ray2> before;
  std::vector<Ray2> now;
};

/// The features that both images show.
SharedRays sharedBetween(const RayMap& before, const RayMap& now);

}  // namespace frugal_nav
