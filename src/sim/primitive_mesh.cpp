#include <cmath>

#include <Eigen/Geometry>

#include <frugal_nav/sim/primitive_mesh.hpp>

namespace frugal_nav::sim {
namespace {

int addVertex(Mesh& mesh, const Eigen::Vector3d& position, const Eigen::Vector3d& normal, double u,
              double v) {
  mesh.vertices.push_back(position.cast<float>());
  mesh.normals.push_back(normal.cast<float>());
  mesh.uvs.emplace_back(static_cast<float>(u), static_cast<float>(v));
  return static_cast<int>(mesh.vertices.size()) - 1;
}

void addTriangle(Mesh& mesh, int a, int b, int c) {
  mesh.triangles.emplace_back(a, b, c);
  mesh.triangle_material.push_back(0);
}

/// A rectangle that spans `right` and `up` (full lengths), seen from the side of right x up.
void addRectangle(Mesh& mesh, const Eigen::Vector3d& centre, const Eigen::Vector3d& right,
                  const Eigen::Vector3d& up) {
  const Eigen::Vector3d normal = right.cross(up).normalized();
  const Eigen::Vector3d corner = centre - 0.5 * right - 0.5 * up;
  const int first = addVertex(mesh, corner, normal, 0.0, 0.0);
  addVertex(mesh, corner + right, normal, 1.0, 0.0);
  addVertex(mesh, corner + right + up, normal, 1.0, 1.0);
  addVertex(mesh, corner + up, normal, 0.0, 1.0);
  addTriangle(mesh, first, first + 1, first + 2);
  addTriangle(mesh, first, first + 2, first + 3);
}

/// Circumradius of a regular polygon, relative to its radius averaged over all directions: that mean is
/// cos(a) artanh(sin a) / a with a = pi / segments.
double cornerFactor(int segments) {
  const double a = M_PI / segments;
  return a / (std::cos(a) * std::atanh(std::sin(a)));
}

void addCap(Mesh& mesh, double radius, double z, int segments) {
  const double side = z < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d normal(0.0, 0.0, side);
  const int centre = addVertex(mesh, {0.0, 0.0, z}, normal, 0.5, 0.5);
  for (int i = 0; i < segments; ++i) {
    const double angle = side * 2.0 * M_PI * i / segments;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    addVertex(mesh, {radius * c, radius * s, z}, normal, 0.5 + 0.5 * c, 0.5 + 0.5 * side * s);
  }
  for (int i = 0; i < segments; ++i) {
    addTriangle(mesh, centre, centre + 1 + i, centre + 1 + (i + 1) % segments);
  }
}

}  // namespace

Mesh makeBox(const Eigen::Vector3d& size_m) {
  Mesh mesh;
  const Eigen::Vector3d x = size_m.x() * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = size_m.y() * Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = size_m.z() * Eigen::Vector3d::UnitZ();
  addRectangle(mesh, 0.5 * x, y, z);
  addRectangle(mesh, -0.5 * x, -y, z);
  addRectangle(mesh, 0.5 * y, -x, z);
  addRectangle(mesh, -0.5 * y, x, z);
  addRectangle(mesh, 0.5 * z, x, y);
  addRectangle(mesh, -0.5 * z, x, -y);
  return mesh;
}

Mesh makeCylinder(double radius_m, double length_m) {
  constexpr double kSlimRadius = 0.1;  // below it the facets are smaller than the sensors resolve
  const int segments = radius_m < kSlimRadius ? 24 : 32;
  const double radius = radius_m * cornerFactor(segments);
  Mesh mesh;
  for (int i = 0; i <= segments; ++i) {
    const double angle = 2.0 * M_PI * i / segments;
    const Eigen::Vector3d outward(std::cos(angle), std::sin(angle), 0.0);
    const Eigen::Vector3d half_up(0.0, 0.0, 0.5 * length_m);
    const double u = static_cast<double>(i) / segments;
    const int low = addVertex(mesh, radius * outward - half_up, outward, u, 0.0);
    addVertex(mesh, radius * outward + half_up, outward, u, 1.0);
    if (i == segments) break;
    addTriangle(mesh, low, low + 2, low + 3);
    addTriangle(mesh, low, low + 3, low + 1);
  }
  addCap(mesh, radius, 0.5 * length_m, segments);
  addCap(mesh, radius, -0.5 * length_m, segments);
  return mesh;
}

Mesh makeSphere(double radius_m) {
  constexpr int kAround = 32;
  constexpr int kRows = 16;
  Mesh mesh;
  for (int row = 0; row <= kRows; ++row) {
    const double latitude = M_PI * (static_cast<double>(row) / kRows - 0.5);
    for (int column = 0; column <= kAround; ++column) {
      const double longitude = 2.0 * M_PI * column / kAround;
      const Eigen::Vector3d outward(std::cos(latitude) * std::cos(longitude),
                                    std::cos(latitude) * std::sin(longitude), std::sin(latitude));
      addVertex(mesh, radius_m * outward, outward, static_cast<double>(column) / kAround,
                static_cast<double>(row) / kRows);
    }
  }
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kAround; ++column) {
      const int low = row * (kAround + 1) + column;
      const int high = low + kAround + 1;
      // At the poles one of the two triangles has no area.
      if (row > 0) addTriangle(mesh, low, low + 1, high + 1);
      if (row < kRows - 1) addTriangle(mesh, low, high + 1, high);
    }
  }
  return mesh;
}

Mesh makePlane(const Eigen::Vector2d& size_m, const Eigen::Vector3d& normal) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal);
  Mesh mesh;
  addRectangle(mesh, Eigen::Vector3d::Zero(), turn * Eigen::Vector3d(size_m.x(), 0.0, 0.0),
               turn * Eigen::Vector3d(0.0, size_m.y(), 0.0));
  return mesh;
}

}  // namespace frugal_nav::sim
