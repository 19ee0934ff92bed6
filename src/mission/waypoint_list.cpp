#include <cmath>

#include <yaml-cpp/yaml.h>

#include <frugal_nav/mission/waypoint_list.hpp>

namespace frugal_nav {
namespace {

std::string place(const std::string& where, const YAML::Mark& mark) {
  return mark.is_null() ? where : where + ":" + std::to_string(mark.line + 1);
}

[[noreturn]] void fail(const std::string& where, const YAML::Node& node, const std::string& what) {
  throw ConfigError(place(where, node.Mark()) + ": " + what);
}

template <class T>
T value(const YAML::Node& node, const std::string& where, const std::string& what) {
  T result{};
  if (!node.IsScalar() || !YAML::convert<T>::decode(node, result)) fail(where, node, what);
  return result;
}

Waypoint parseWaypoint(const YAML::Node& node, const std::string& where, std::size_t number) {
  const std::string entry = "waypoint " + std::to_string(number);
  if (!node.IsSequence() || (node.size() != 2 && node.size() != 3))
    fail(where, node, entry + " must be [x, y] or [x, y, yaw] in metres and radians");
  double numbers[3] = {0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < node.size(); ++i) {
    numbers[i] = value<double>(node[i], where, entry + " holds something that is not a number");
    if (!std::isfinite(numbers[i])) fail(where, node, entry + " is not finite");
  }
  Waypoint waypoint;
  waypoint.position = {numbers[0], numbers[1]};
  if (node.size() == 3) waypoint.yaw_rad = numbers[2];
  return waypoint;
}

WaypointList parse(const YAML::Node& root, const std::string& where) {
  if (!root.IsMap()) throw ConfigError(where + ": expected \"frame\" and \"waypoints\"");
  WaypointList list;
  for (const auto& entry : root) {
    const auto key = entry.first.Scalar();
    const YAML::Node& node = entry.second;
    if (key == "frame") {
      list.frame = value<std::string>(node, where, "\"frame\" must be a frame's name, such as odom");
    } else if (key == "loop") {
      list.loop = value<bool>(node, where, "\"loop\" must be true or false");
    } else if (key == "start_delay_s") {
      list.start_delay_s = value<double>(node, where, "\"start_delay_s\" must be a number of seconds");
      if (!(list.start_delay_s >= 0.0)) fail(where, node, "\"start_delay_s\" must not be negative");
    } else if (key == "waypoints") {
      if (!node.IsSequence()) fail(where, node, "\"waypoints\" must be a list of [x, y] or [x, y, yaw]");
      for (std::size_t i = 0; i < node.size(); ++i)
        list.waypoints.push_back(parseWaypoint(node[i], where, i + 1));
    } else {
      fail(where, entry.first,
           "unknown key \"" + key + "\"; known are frame, waypoints, loop and start_delay_s");
    }
  }
  if (list.frame.empty()) throw ConfigError(where + ": \"frame\" is missing; name the frame, such as odom");
  if (list.waypoints.empty()) throw ConfigError(where + ": \"waypoints\" is missing or empty");
  return list;
}

}  // namespace

WaypointList readWaypoints(const std::string& path) {
  try {
    return parse(YAML::LoadFile(path), path);
  } catch (const YAML::BadFile&) {
    throw ConfigError(path + ": cannot be read; is the path right?");
  } catch (const YAML::Exception& error) {
    throw ConfigError(place(path, error.mark) + ": " + error.msg);
  }
}

WaypointList parseWaypoints(const std::string& yaml, const std::string& where) {
  try {
    return parse(YAML::Load(yaml), where);
  } catch (const YAML::Exception& error) {
    throw ConfigError(place(where, error.mark) + ": " + error.msg);
  }
}

}  // namespace frugal_nav
