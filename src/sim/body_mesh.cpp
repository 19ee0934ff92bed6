#include "body_mesh.hpp"

#include <algorithm>
#include <cmath>

namespace frugal_nav::sim {
namespace {

/// Normal at a grid point from its neighbours, wrapping around the columns; `fallback` at a pole.
Eigen::Vector3d normalAt(const Sheet& sheet, std::size_t row, std::size_t column,
                         const Eigen::Vector3d& fallback) {
  const std::size_t columns = sheet.rows[row].size();
  const std::size_t below = row == 0 ? 0 : row - 1;
  const std::size_t above = std::min(row + 1, sheet.rows.size() - 1);
  const Eigen::Vector3d around =
      sheet.rows[row][(column + 1) % columns] - sheet.rows[row][(column + columns - 1) % columns];
  const Eigen::Vector3d up = sheet.rows[above][column] - sheet.rows[below][column];
  const Eigen::Vector3d normal = around.cross(up);
  constexpr double kTiny = 1e-12;
  return normal.norm() > kTiny ? normal.normalized() : fallback;
}

}  // namespace

void addSheet(const Sheet& sheet, Mesh& mesh) {
  const std::size_t columns = sheet.rows.front().size();
  const int first = static_cast<int>(mesh.vertices.size());
  for (std::size_t row = 0; row < sheet.rows.size(); ++row) {
    const Eigen::Vector3d pole(0.0, 0.0, row == 0 ? -1.0 : 1.0);
    for (std::size_t i = 0; i <= columns; ++i) {
      const std::size_t column = i % columns;
      mesh.vertices.push_back(sheet.rows[row][column].cast<float>());
      mesh.normals.push_back(normalAt(sheet, row, column, pole).cast<float>());
      mesh.uvs.emplace_back(static_cast<float>(sheet.column_u[i]), static_cast<float>(sheet.row_v[row]));
    }
  }
  const int stride = static_cast<int>(columns) + 1;
  for (std::size_t row = 0; row + 1 < sheet.rows.size(); ++row) {
    for (int i = 0; i + 1 < stride; ++i) {
      const int low = first + static_cast<int>(row) * stride + i;
      const auto flat = [&mesh](int a, int b) {
        return (mesh.vertices[static_cast<std::size_t>(a)] - mesh.vertices[static_cast<std::size_t>(b)])
                   .norm() < 1e-6F;
      };
      const auto triangle = [&](int a, int b, int c) {
        mesh.triangles.emplace_back(a, b, c);
        mesh.triangle_material.push_back(sheet.band_material[row]);
      };
      if (!flat(low, low + 1)) triangle(low, low + 1, low + stride + 1);
      if (!flat(low + stride, low + stride + 1)) triangle(low, low + stride + 1, low + stride);
    }
  }
}

void addLoft(const std::vector<Ring>& rings, int columns, double squareness, Mesh& mesh) {
  Sheet sheet;
  for (int i = 0; i <= columns; ++i) sheet.column_u.push_back(static_cast<double>(i) / columns);
  const double low = rings.front().z;
  const double length = std::max(rings.back().z - low, 1e-9);
  const auto addRow = [&](const Ring& ring, double scale) {
    std::vector<Eigen::Vector3d> row;
    for (int i = 0; i < columns; ++i) {
      const double angle = 2.0 * M_PI * i / columns - M_PI;
      const double c = std::cos(angle);
      const double s = std::sin(angle);
      // Superellipse: the radius at which |x|^n + |y|^n = 1.
      const double reach =
          std::pow(std::pow(std::abs(c), squareness) + std::pow(std::abs(s), squareness), -1.0 / squareness);
      row.emplace_back(ring.x + scale * ring.half_depth * reach * c, scale * ring.half_width * reach * s,
                       ring.z);
    }
    sheet.rows.push_back(row);
    sheet.row_v.push_back((ring.z - low) / length);
    sheet.band_material.push_back(ring.material);
  };
  addRow(rings.front(), 0.0);
  for (const Ring& ring : rings) addRow(ring, 1.0);
  addRow(rings.back(), 0.0);
  addSheet(sheet, mesh);
}

void addEllipsoid(const Eigen::Vector3d& centre, const Eigen::Vector3d& radii, int material, Mesh& mesh) {
  constexpr int kColumns = 10;
  constexpr int kRows = 6;
  std::vector<Ring> rings;
  for (int row = 1; row < kRows; ++row) {
    const double latitude = M_PI * (static_cast<double>(row) / kRows - 0.5);
    const double girth = std::cos(latitude);
    rings.push_back({radii.z() * std::sin(latitude), radii.x() * girth, radii.y() * girth, 0.0, material});
  }
  Mesh ellipsoid;
  addLoft(rings, kColumns, 2.0, ellipsoid);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = centre;
  ellipsoid = moved(std::move(ellipsoid), pose);
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), ellipsoid.vertices.begin(), ellipsoid.vertices.end());
  mesh.normals.insert(mesh.normals.end(), ellipsoid.normals.begin(), ellipsoid.normals.end());
  mesh.uvs.insert(mesh.uvs.end(), ellipsoid.uvs.begin(), ellipsoid.uvs.end());
  for (const Eigen::Vector3i& triangle : ellipsoid.triangles) {
    mesh.triangles.emplace_back(triangle.array() + first);
    mesh.triangle_material.push_back(material);
  }
}

Mesh moved(Mesh mesh, const Eigen::Isometry3d& target_from_mesh) {
  const Eigen::Isometry3f motion = target_from_mesh.cast<float>();
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex = motion * vertex;
  for (Eigen::Vector3f& normal : mesh.normals) normal = motion.linear() * normal;
  return mesh;
}

}  // namespace frugal_nav::sim
