#pragma once

#include <functional>
#include <vector>

#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

/// A surface of rows of points, closed around its columns: rows from the bottom up, columns from behind
/// (-x) over the right side (-y) to the front and back, so that it faces outward.
struct Sheet {
  std::vector<std::vector<Eigen::Vector3d>> rows;  ///< each without the point that closes it
  std::vector<double> column_u;    ///< texture coordinate of each column and of the closing one
  std::vector<double> row_v;       ///< texture coordinate of each row
  std::vector<int> band_material;  ///< of the band above each row but the last
};

/// One cross-section of a limb: an ellipse about (x, 0, z), flattened by `squareness` (2 is an ellipse).
struct Ring {
  double z = 0.0;
  double half_depth = 0.0;  ///< along x
  double half_width = 0.0;  ///< along y
  double x = 0.0;
  int material = 0;  ///< of the surface from here up to the next ring
};

/// Adds a sheet with smooth normals.
void addSheet(const Sheet& sheet, Mesh& mesh);

/// Adds a surface through rings from the bottom up, closed at both ends.
void addLoft(const std::vector<Ring>& rings, int columns, double squareness, Mesh& mesh);

/// Adds an ellipsoid of one material.
void addEllipsoid(const Eigen::Vector3d& centre, const Eigen::Vector3d& radii, int material, Mesh& mesh);

/// A mesh turned and moved.
Mesh moved(Mesh mesh, const Eigen::Isometry3d& target_from_mesh);

}  // namespace frugal_nav::sim
