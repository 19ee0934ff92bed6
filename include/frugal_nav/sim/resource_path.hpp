#pragma once

#include <optional>
#include <string>
#include <vector>

namespace frugal_nav::sim {

/// Where the files that a world names are looked for.
class ResourcePath {
 public:
  ResourcePath() = default;
  /// `model_folders` hold one folder a model (GAZEBO_MODEL_PATH); `package_folders` hold ROS packages or are
  /// packages themselves (ROS_PACKAGE_PATH). The first match wins.
  ResourcePath(std::vector<std::string> model_folders, std::vector<std::string> package_folders);

  /// The folders of GAZEBO_MODEL_PATH and ROS_PACKAGE_PATH.
  static ResourcePath fromEnvironment();

  /// The same search with the world's own folder and its sibling `models` at the end of the model folders.
  ResourcePath withWorld(const std::string& world_path) const;

  /// The existing file or folder that a URI names: `model://NAME/...`, `package://NAME/...`, `file://...`, an
  /// absolute path, or a path relative to `base_folder`. Nothing when there is none.
  std::optional<std::string> find(const std::string& uri, const std::string& base_folder) const;

  const std::vector<std::string>& modelFolders() const { return model_folders_; }
  const std::vector<std::string>& packageFolders() const { return package_folders_; }

 private:
  std::optional<std::string> findInModels(const std::string& path) const;
  std::optional<std::string> findInPackages(const std::string& path) const;

  std::vector<std::string> model_folders_;
  std::vector<std::string> package_folders_;
};

/// A texture as a mesh names it. Exporters write paths of their own machine or with one `..` too many, so
/// that its base name is also looked for in the folders where Gazebo models keep textures.
std::optional<std::string> findTexture(const std::string& name, const std::string& mesh_folder,
                                       const ResourcePath& resources);

}  // namespace frugal_nav::sim
