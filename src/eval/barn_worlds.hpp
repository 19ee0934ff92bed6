#pragma once

#include <string>
#include <vector>

namespace frugal_nav::eval {

/// A world of the BARN challenge's format.
struct BarnWorld {
  int number = 0;
  std::string path;  ///< of its SDF file
  double path_length_m = 0.0;
};

/// The worlds of a folder, by number: files world_NUMBER.world in it or below, and path_lengths.csv (world,
/// path_length_m) in it or beside it. Throws ConfigError naming what is missing.
std::vector<BarnWorld> listBarnWorlds(const std::string& folder);

}  // namespace frugal_nav::eval
