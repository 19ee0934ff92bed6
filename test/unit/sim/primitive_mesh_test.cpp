#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <frugal_nav/sim/primitive_mesh.hpp>

namespace frugal_nav::sim {
namespace {

struct Measures {
  double area_m2 = 0.0;
  double volume_m3 = 0.0;
  bool normals_agree = true;
};

Measures measure(const Mesh& mesh) {
  Measures result;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    const auto at = [](const auto& list, int i) { return list[static_cast<std::size_t>(i)]; };
    const Eigen::Vector3d a = at(mesh.vertices, triangle[0]).cast<double>();
    const Eigen::Vector3d b = at(mesh.vertices, triangle[1]).cast<double>();
    const Eigen::Vector3d c = at(mesh.vertices, triangle[2]).cast<double>();
    const Eigen::Vector3d twice_area = (b - a).cross(c - a);
    result.area_m2 += 0.5 * twice_area.norm();
    result.volume_m3 += a.dot(twice_area) / 6.0;
    for (int k = 0; k < 3; ++k) {
      if (at(mesh.normals, triangle[k]).cast<double>().dot(twice_area) <= 0.0) result.normals_agree = false;
    }
  }
  EXPECT_EQ(mesh.normals.size(), mesh.vertices.size());
  EXPECT_EQ(mesh.uvs.size(), mesh.vertices.size());
  EXPECT_EQ(mesh.triangle_material.size(), mesh.triangles.size());
  for (const Eigen::Vector2f& uv : mesh.uvs) {
    EXPECT_TRUE(uv.minCoeff() >= 0.0F && uv.maxCoeff() <= 1.0F);
  }
  return result;
}

TEST(PrimitiveMesh, BoxIsClosedAndFacesOutward) {
  const Measures box = measure(makeBox({1.0, 2.0, 3.0}));
  EXPECT_NEAR(box.area_m2, 22.0, 1e-5);
  EXPECT_NEAR(box.volume_m3, 6.0, 1e-5);
  EXPECT_TRUE(box.normals_agree);
}

TEST(PrimitiveMesh, CylinderHasTheTrueMeanRadius) {
  for (const double radius : {0.075, 0.5}) {
    const Mesh mesh = makeCylinder(radius, 2.0);
    const Measures cylinder = measure(mesh);
    EXPECT_TRUE(cylinder.normals_agree);
    // A polygon of 24 or 32 corners of the same mean radius has almost the circle's area: the difference is
    // of the fourth order in pi / 24, below 1e-4.
    EXPECT_NEAR(cylinder.volume_m3 / (M_PI * radius * radius * 2.0), 1.0, 2e-4);
    double sum = 0.0;
    constexpr int kRays = 10000;
    const int segments = radius < 0.1 ? 24 : 32;
    const double corner = mesh.vertices[0].head<2>().cast<double>().norm();
    for (int i = 0; i < kRays; ++i) {
      const double from_middle = (static_cast<double>(i) / kRays - 0.5) * 2.0 * M_PI / segments;
      sum += corner * std::cos(M_PI / segments) / std::cos(from_middle);
    }
    EXPECT_NEAR(sum / kRays, radius, 1e-6);
  }
}

TEST(PrimitiveMesh, SphereHasItsRadius) {
  const Mesh mesh = makeSphere(0.5);
  const Measures sphere = measure(mesh);
  EXPECT_TRUE(sphere.normals_agree);
  for (const Eigen::Vector3f& vertex : mesh.vertices) EXPECT_NEAR(vertex.norm(), 0.5F, 1e-6F);
  // An inscribed body of 32 x 16 facets lacks about 2 % of the volume.
  EXPECT_NEAR(sphere.volume_m3 / (4.0 / 3.0 * M_PI * 0.125), 0.98, 0.01);
}

TEST(PrimitiveMesh, PlaneFacesAlongItsNormal) {
  const Mesh mesh = makePlane({4.0, 2.0}, {0.0, -1.0, 0.0});
  const Measures plane = measure(mesh);
  EXPECT_NEAR(plane.area_m2, 8.0, 1e-5);
  EXPECT_TRUE(plane.normals_agree);
  for (const Eigen::Vector3f& normal : mesh.normals) EXPECT_NEAR(normal.y(), -1.0F, 1e-6F);
  const Mesh below = makePlane({4.0, 2.0}, {0.0, 0.0, -1.0});
  EXPECT_NEAR(below.normals[0].z(), -1.0F, 1e-6F);
}

TEST(PrimitiveMesh, BoxTexturesStandUprightOnTheSides) {
  const Mesh mesh = makeBox({1.0, 1.0, 1.0});
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (std::abs(mesh.normals[i].z()) > 0.5F) continue;
    EXPECT_EQ(mesh.uvs[i].y() > 0.5F, mesh.vertices[i].z() > 0.0F);
    // Seen from outside, right is up x normal.
    const Eigen::Vector3f right = Eigen::Vector3f::UnitZ().cross(mesh.normals[i]);
    EXPECT_EQ(mesh.uvs[i].x() > 0.5F, mesh.vertices[i].dot(right) > 0.0F);
  }
}

}  // namespace
}  // namespace frugal_nav::sim
