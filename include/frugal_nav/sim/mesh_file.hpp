#pragma once

#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/sim/resource_path.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

/// What a mesh file holds, before it joins a scene: metres, z up; `mesh.triangle_material` indexes
/// `materials`, and their `texture` indexes `textures`.
struct MeshFile {
  Mesh mesh;
  std::vector<Material> materials;
  std::vector<Texture> textures;
  std::vector<std::string> files;     ///< every file that was read
  std::vector<std::string> warnings;  ///< textures that are missing or cannot be read
};

/// A part of a mesh file, as SDF's `<submesh>` names it. An empty name stands for the whole file.
struct Submesh {
  std::string name;
  bool is_centered = false;  ///< move the middle of its bounding box to the origin
};

/// Reads DAE, OBJ, STL, glTF and what else assimp knows. Axes as Gazebo takes them: a DAE's `up_axis` is
/// ignored; glTF, whose y is up by definition, is turned. Throws std::runtime_error naming file and cause.
MeshFile readMeshFile(const std::string& path, const Submesh& submesh, const ResourcePath& resources);

/// Reads an image; larger ones are shrunk to 1024 pixels. Nothing when it cannot be decoded.
std::optional<Texture> readTexture(const std::string& path);

/// Drops triangles without area and those which repeat an earlier one (some exporters write every face twice,
/// with reversed winding), and computes normals when some are absent or a doubled face made them worthless.
void cleanMesh(Mesh& mesh);

/// Scales a mesh along its axes; a mirroring scale keeps the triangles' outside.
void scaleMesh(Mesh& mesh, const Eigen::Vector3d& scale);

}  // namespace frugal_nav::sim
