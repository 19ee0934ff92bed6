#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>

#include <Eigen/Geometry>

#include <frugal_nav/sim/mesh_file.hpp>

namespace frugal_nav::sim {
namespace {

/// For each vertex the index of the first one at the same place.
std::vector<int> weldedIndices(const Mesh& mesh) {
  std::map<std::array<float, 3>, int> first_at;
  std::vector<int> welded;
  welded.reserve(mesh.vertices.size());
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    const auto next = static_cast<int>(welded.size());
    // Adding zero makes -0 and 0 the same place.
    const std::array<float, 3> place{vertex.x() + 0.0F, vertex.y() + 0.0F, vertex.z() + 0.0F};
    welded.push_back(vertex.allFinite() ? first_at.emplace(place, next).first->second : next);
  }
  return welded;
}

Eigen::Vector3f areaNormal(const Mesh& mesh, const Eigen::Vector3i& triangle) {
  const auto corner = [&](int i) { return mesh.vertices[static_cast<std::size_t>(triangle[i])]; };
  return (corner(1) - corner(0)).cross(corner(2) - corner(0));
}

/// Drops triangles without area and those whose corners an earlier one has. True when one was doubled.
bool dropTriangles(Mesh& mesh, const std::vector<int>& welded) {
  std::set<std::array<int, 3>> seen;
  bool was_doubled = false;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3i triangle = mesh.triangles[i];
    const float area = areaNormal(mesh, triangle).norm();
    if (!(area > 0.0F) || !std::isfinite(area)) continue;
    std::array<int, 3> corners{};
    for (int k = 0; k < 3; ++k) {
      corners[static_cast<std::size_t>(k)] = welded[static_cast<std::size_t>(triangle[k])];
    }
    std::sort(corners.begin(), corners.end());
    if (!seen.insert(corners).second) {
      was_doubled = true;
      continue;
    }
    mesh.triangles[kept] = triangle;
    mesh.triangle_material[kept++] = mesh.triangle_material[i];
  }
  mesh.triangles.resize(kept);
  mesh.triangle_material.resize(kept);
  return was_doubled;
}

/// Normals of corners: the mean over the triangles around the place that are within 45 degrees of the
/// corner's own, so that edges stay sharp and curves smooth. Where windings disagree the neighbour counts
/// turned over.
void computeNormals(Mesh& mesh, const std::vector<int>& welded) {
  const float kSmoothCosine = std::sqrt(0.5F);
  std::vector<Eigen::Vector3f> faces;
  faces.reserve(mesh.triangles.size());
  std::unordered_map<int, std::vector<int>> faces_at;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      faces_at[welded[static_cast<std::size_t>(triangle[k])]].push_back(static_cast<int>(faces.size()));
    }
    faces.push_back(areaNormal(mesh, triangle));
  }

  Mesh split;
  split.triangle_material = mesh.triangle_material;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto first = static_cast<int>(split.vertices.size());
    split.triangles.emplace_back(first, first + 1, first + 2);
    const Eigen::Vector3f own = faces[i].normalized();
    for (int k = 0; k < 3; ++k) {
      const auto vertex = static_cast<std::size_t>(mesh.triangles[i][k]);
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (const int face : faces_at[welded[vertex]]) {
        const Eigen::Vector3f& other = faces[static_cast<std::size_t>(face)];
        const float along = own.dot(other);
        if (std::abs(along) >= kSmoothCosine * other.norm()) sum += along < 0.0F ? -other : other;
      }
      split.vertices.push_back(mesh.vertices[vertex]);
      split.normals.push_back(sum.normalized());
      if (!mesh.uvs.empty()) split.uvs.push_back(mesh.uvs[vertex]);
    }
  }
  mesh = std::move(split);
}

}  // namespace

void cleanMesh(Mesh& mesh) {
  const std::vector<int> welded = weldedIndices(mesh);
  const bool was_doubled = dropTriangles(mesh, welded);
  const bool lacks_normals = mesh.normals.size() != mesh.vertices.size() ||
                             std::any_of(mesh.normals.begin(), mesh.normals.end(),
                                         [](const Eigen::Vector3f& n) { return !(n.norm() > 0.5F); });
  if (was_doubled || lacks_normals) computeNormals(mesh, welded);
}

}  // namespace frugal_nav::sim
