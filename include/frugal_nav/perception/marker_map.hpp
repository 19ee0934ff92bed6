#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace frugal_nav {

/// A marker that hangs somewhere. Its frame: origin in the centre, x right, y up, z out of the printed face.
struct MappedMarker {
  int id = -1;
  double size_m = 0.0;  ///< side of the black square
  Eigen::Isometry3d map_from_marker = Eigen::Isometry3d::Identity();

  /// The corners in the marker's frame, in the order of MarkerCorners.
  std::array<Eigen::Vector3d, 4> corners() const;
};

/// The corners of a marker of a size in its own frame: upper left, upper right, lower right, lower left.
std::array<Eigen::Vector3d, 4> markerCorners(double size_m);

/// Where the markers hang.
struct MarkerMap {
  std::string frame = "map";
  std::string dictionary = "DICT_4X4_50";
  std::map<int, MappedMarker> markers;
  std::vector<int> whitelist;  ///< ids to use: those of the file's `whitelist`, else all that are mapped
};

/// A map from a YAML file:
///
///     frame: map
///     dictionary: DICT_4X4_50
///     size_m: 0.20                # of those that name none
///     whitelist: [0, 1]           # optional: the only ids to use
///     markers:
///       - {id: 0, position: [4.0, 0.0, 0.5], rpy: [1.5708, 0.0, -1.5708]}       # on a wall, faces -x
///       - {id: 1, size_m: 0.15, position: [0.0, 2.0, 0.5], rpy: [1.5708, 0.0, 0.0]}  # faces -y
///
/// Metres and radians; rpy turns about the fixed axes x, y, z in this order, as in URDF.
/// Throws ConfigError with every fault of the file, one a line, each with the key it is about.
MarkerMap loadMarkerMap(const std::string& path);

/// The same from a text; `where` stands in the messages.
MarkerMap parseMarkerMap(const std::string& yaml, const std::string& where);

}  // namespace frugal_nav
