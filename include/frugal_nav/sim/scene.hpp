#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/common/geometry.hpp>

namespace frugal_nav::sim {

/// An image that covers a surface: rows from the top, 8-bit sRGB, three channels.
struct Texture {
  std::string name;
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> rgb;
};

/// How a surface reflects. Diffuse only: what a wheeled robot's camera has to cope with is texture and light.
struct Material {
  std::string name;
  Eigen::Vector3f albedo{0.7F, 0.7F, 0.7F};    ///< sRGB in [0, 1]; multiplies the texture
  Eigen::Vector3f emission{0.0F, 0.0F, 0.0F};  ///< sRGB in [0, 1]: lamps and screens
  int texture = -1;                            ///< index into Scene::textures, -1 for none
};

/// Triangles in their own frame [m]. Normals and texture coordinates are one a vertex, or absent.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Vector3f> normals;
  std::vector<Eigen::Vector2f> uvs;  ///< origin at the texture's bottom left, v up
  std::vector<Eigen::Vector3i> triangles;
  std::vector<int> triangle_material;  ///< index into Scene::materials, one a triangle
};

/// One drawn mesh of a model.
struct Visual {
  int mesh = -1;  ///< index into Scene::meshes; several visuals may share one
  Eigen::Isometry3d model_from_visual = Eigen::Isometry3d::Identity();
};

/// One solid shape of a model, for contact.
struct Collision {
  enum class Kind { kBox, kCylinder, kSphere, kPlane, kMesh };
  Kind kind = Kind::kBox;
  Eigen::Vector3d size_m = Eigen::Vector3d::Ones();  ///< box: side lengths; cylinder, sphere: (radius,
                                                     ///< radius, length); plane: normal
  int mesh = -1;                                     ///< index into Scene::meshes, for kMesh
  Eigen::Isometry3d model_from_collision = Eigen::Isometry3d::Identity();
};

/// A thing in the world. What moves does so by changing `world_from_model`.
struct Model {
  std::string name;
  Eigen::Isometry3d world_from_model = Eigen::Isometry3d::Identity();
  std::vector<Visual> visuals;
  std::vector<Collision> collisions;
};

/// A light as SDF describes it; the light setting scales all of them to a wanted illuminance.
struct Light {
  enum class Kind { kDirectional, kPoint, kSpot };
  std::string name;
  Kind kind = Kind::kPoint;
  Eigen::Vector3f color{1.0F, 1.0F, 1.0F};  ///< linear, relative
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = -Eigen::Vector3d::UnitZ();  ///< the way the light travels, unit length
  double range_m = 20.0;
  double attenuation_constant = 1.0;
  double attenuation_linear = 0.0;     ///< [1/m]
  double attenuation_quadratic = 0.0;  ///< [1/m^2]
  double spot_inner_rad = 0.6;
  double spot_outer_rad = 1.0;
  bool casts_shadows = true;
};

enum class Posture { kStanding, kSitting, kWalking };

/// A place and time on a person's way.
struct Waypoint {
  double time_s = 0.0;
  Pose2 world_from_person;
};

/// A person; the body is made from `appearance` by people.hpp. A standing or sitting one has one waypoint.
struct Person {
  std::string name;
  Posture posture = Posture::kStanding;
  std::uint64_t appearance = 0;  ///< seed of build, clothes, skin and hair
  std::vector<Waypoint> waypoints;
  double start_delay_s = 0.0;
  bool loop = true;  ///< start again after the last waypoint
};

/// All there is in a world, in plain data: what the world file's reader makes and every sensor reads.
struct Scene {
  std::string name;
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Model> models;
  std::vector<Light> lights;
  std::vector<Person> people;
  Eigen::Vector3f ambient{0.3F, 0.3F, 0.3F};     ///< linear, relative to the lights
  Eigen::Vector3f background{0.6F, 0.7F, 0.8F};  ///< sRGB, where a ray hits nothing
};

}  // namespace frugal_nav::sim
