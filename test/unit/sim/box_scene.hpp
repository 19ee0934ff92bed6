#pragma once

#include <string>

#include <Eigen/Geometry>

#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

/// A pose without rotation.
inline Eigen::Isometry3d at(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

/// The optical frame of a camera at a place, looking along the world's x, upright (REP-103).
inline Eigen::Isometry3d lookAlongX(double x, double y, double z) {
  Eigen::Isometry3d pose = at(x, y, z);
  pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return pose;
}

/// The optical frame of a camera at a place, looking straight down with the world's x to the right.
inline Eigen::Isometry3d lookDown(double x, double y, double z) {
  Eigen::Isometry3d pose = at(x, y, z);
  pose.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  return pose;
}

/// A scene of boxes, each a model of its own.
class BoxScene {
 public:
  BoxScene() { scene.ambient.setZero(); }

  int addMaterial(const Eigen::Vector3f& srgb) {
    Material material;
    material.albedo = srgb;
    scene.materials.push_back(material);
    return static_cast<int>(scene.materials.size()) - 1;
  }

  /// Returns the index of the new model.
  int addBox(const Eigen::Vector3f& size_m, const Eigen::Isometry3d& world_from_box, int material) {
    Mesh mesh;
    for (int i = 0; i < 8; ++i) {
      mesh.vertices.emplace_back(0.5F * size_m.x() * sign(i & 1), 0.5F * size_m.y() * sign(i & 2),
                                 0.5F * size_m.z() * sign(i & 4));
    }
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    mesh.triangle_material.assign(12, material);
    scene.meshes.push_back(mesh);
    Model model;
    model.name = "box" + std::to_string(scene.models.size());
    model.world_from_model = world_from_box;
    model.visuals.push_back({static_cast<int>(scene.meshes.size()) - 1, Eigen::Isometry3d::Identity()});
    scene.models.push_back(model);
    return static_cast<int>(scene.models.size()) - 1;
  }

  void addSun(const Eigen::Vector3d& direction) {
    Light light;
    light.kind = Light::Kind::kDirectional;
    light.direction = direction.normalized();
    scene.lights.push_back(light);
  }

  Scene scene;

 private:
  static float sign(int bit) { return bit != 0 ? 1.0F : -1.0F; }
};

}  // namespace frugal_nav::sim
