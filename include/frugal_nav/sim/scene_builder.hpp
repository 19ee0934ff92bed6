#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <frugal_nav/sim/mesh_file.hpp>
#include <frugal_nav/sim/resource_path.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

/// What a visual says about its surface, over what its mesh file says.
struct Surface {
  Material material;
  bool has_color = false;  ///< else a mesh file's own colours stay
};

/// Fills a Scene in which equal materials, textures and meshes are shared, and notes what went wrong.
class SceneBuilder {
 public:
  explicit SceneBuilder(ResourcePath resources) : resources_(std::move(resources)) {}

  /// Index of a simple shape's mesh, all of one material. `key` names shape and size; `make` is called when
  /// there is no such mesh yet.
  int addPrimitive(const std::string& key, const std::function<Mesh()>& make, const Material& material);

  /// Index of a mesh file's mesh. Nothing, and a warning, when the file is missing or cannot be read.
  std::optional<int> addMeshFile(const std::string& uri, const std::string& base_folder,
                                 const Submesh& submesh, const Eigen::Vector3d& scale,
                                 const std::optional<Surface>& surface, const std::string& owner);

  /// Index of an image as a texture; -1, and a warning, when it is missing or no image.
  int addTexture(const std::string& uri, const std::string& base_folder, const std::string& owner);

  /// Notes a text once.
  void warn(const std::string& text);
  /// Notes a text about a file that was not found: a later run may find it.
  void warnMissing(const std::string& text);
  /// Notes that the scene rests on a file.
  void noteFile(const std::string& path);

  const ResourcePath& resources() const { return resources_; }
  bool isComplete() const { return is_complete_; }
  const std::vector<std::string>& files() const { return files_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  Scene scene;

 private:
  using FileKey = std::tuple<std::string, std::string, bool>;

  int addMaterial(const Material& material);
  int addMesh(Mesh mesh);
  const MeshFile* readOnce(const std::string& path, const Submesh& submesh);
  std::vector<int> materialsOf(const MeshFile& file, const std::optional<Surface>& surface);

  ResourcePath resources_;
  bool is_complete_ = true;
  std::vector<std::string> files_;
  std::vector<std::string> warnings_;
  std::map<std::string, int> mesh_by_key_;
  std::map<std::string, int> texture_by_path_;
  std::map<FileKey, std::optional<MeshFile>> mesh_files_;
};

}  // namespace frugal_nav::sim
