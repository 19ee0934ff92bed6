#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// One place of a tour; without a yaw the robot keeps the heading it arrives with.
struct Waypoint {
  Eigen::Vector2d position{0.0, 0.0};  ///< in the list's frame [m]
  std::optional<double> yaw_rad;
};

/// A tour: places to drive to one after the other.
struct WaypointList {
  std::string frame;
  std::vector<Waypoint> waypoints;
  bool loop = false;           ///< start again after the last one
  double start_delay_s = 0.0;  ///< from the first odometry to the first goal
};

/// Reads a tour from a YAML file: `frame`, `waypoints` (a list of [x, y] or [x, y, yaw]), and optionally
/// `loop` and `start_delay_s`. Throws ConfigError that names the file, the line and the entry.
WaypointList readWaypoints(const std::string& path);

/// The same from a YAML text; `where` stands in the messages.
WaypointList parseWaypoints(const std::string& yaml, const std::string& where);

}  // namespace frugal_nav
