#pragma once

#include <string>

#include <frugal_nav/sim/resource_path.hpp>
#include <frugal_nav/sim/sdf_world.hpp>

namespace frugal_nav::sim {

/// As loadWorld, but keeps the result in `cache_folder` (made when absent; empty for none) and takes it from
/// there as long as the world's bytes, the search folders and size and time of every file it names are the
/// same. A cache that is broken, old or cannot be written costs time only. Worlds with missing files are not
/// kept.
LoadedWorld loadWorldCached(const std::string& path, const ResourcePath& resources,
                            const std::string& cache_folder);

/// $XDG_CACHE_HOME/frugal_nav, or ~/.cache/frugal_nav; empty when neither variable is set.
std::string defaultCacheFolder();

}  // namespace frugal_nav::sim
