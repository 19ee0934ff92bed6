#include "triangle_geometry.hpp"

#include <algorithm>
#include <string>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav::sim {

RTCGeometry makeGeometry(RTCDevice device, const Mesh& mesh, const Eigen::Isometry3d& pose) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f p = (pose * mesh.vertices[i].cast<double>()).cast<float>();
    std::copy_n(p.data(), 3, vertices + 3 * i);
  }
  auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), mesh.triangles.size()));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k)
      indices[3 * i + static_cast<std::size_t>(k)] = static_cast<unsigned>(mesh.triangles[i][k]);
  }
  rtcCommitGeometry(geometry);
  return geometry;
}

void checkMesh(const Scene& scene, const Model& model, const Visual& visual) {
  if (visual.mesh < 0 || visual.mesh >= static_cast<int>(scene.meshes.size())) {
    throw ConfigError("model '" + model.name + "': a visual names mesh " + std::to_string(visual.mesh) +
                      " of " + std::to_string(scene.meshes.size()));
  }
  const Mesh& mesh = scene.meshes[static_cast<std::size_t>(visual.mesh)];
  const int count = static_cast<int>(mesh.vertices.size());
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    if (triangle.minCoeff() < 0 || triangle.maxCoeff() >= count) {
      throw ConfigError("model '" + model.name + "': a triangle names a vertex its mesh does not have");
    }
  }
}

}  // namespace frugal_nav::sim
