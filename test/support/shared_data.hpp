#pragma once

#include <fstream>
#include <string>

namespace frugal_nav::test {

/// A file of the real data that may lie beside the source tree; empty when it does not.
inline std::string sharedFile(const std::string& name) {
  const std::string path = std::string(FRUGAL_NAV_SOURCE_DIR) + "/../shared/data/" + name;
  return std::ifstream(path) ? path : std::string();
}

/// The folder of real networks; empty when it is not there.
inline std::string sharedModels() {
  return sharedFile("models/person.jpg").empty()
             ? std::string()
             : std::string(FRUGAL_NAV_SOURCE_DIR) + "/../shared/data/models";
}

}  // namespace frugal_nav::test
