#pragma once

#include <string>
#include <vector>

#include <frugal_nav/sim/resource_path.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

/// A world file's content.
struct LoadedWorld {
  Scene scene;
  std::vector<std::string> warnings;  ///< what is missing, wrong or not simulated, each named once
  std::vector<std::string> files;     ///< every file that was read for it
  bool is_complete = true;            ///< false when a file it names was not found
};

/// Reads an SDF world as Gazebo users write them. The world's own folder and its sibling `models` join the
/// search. Models keep their name; nested models become part of the outermost one. As in Gazebo classic,
/// poses of a saved `<state>` win, and actors' waypoints are in the world's frame. Throws ConfigError, with
/// file and where known the line, when the file is missing, is no XML or has no world. (The parser library
/// keeps a log at ~/.sdformat/sdformat.log.)
LoadedWorld loadWorld(const std::string& path, const ResourcePath& resources);

}  // namespace frugal_nav::sim
