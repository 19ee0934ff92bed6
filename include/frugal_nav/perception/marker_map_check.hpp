#pragma once

#include <string>
#include <vector>

#include <frugal_nav/perception/marker_map.hpp>

namespace frugal_nav {

/// What a camera on a robot on the floor z = 0 can see of a map.
struct MarkerMapLimits {
  double min_height_m = 0.0;   ///< of a marker's lower edge
  double max_height_m = 2.5;   ///< of its centre
  double max_tilt_deg = 45.0;  ///< of its face from upright
};

/// What a map may hold but is probably a mistake, one sentence each: markers that overlap, out of the
/// camera's reach by height or tilt, so far apart that the unit is in doubt, and whitelisted ids without a
/// place.
std::vector<std::string> suspicionsAbout(const MarkerMap& map, const MarkerMapLimits& limits = {});

}  // namespace frugal_nav
