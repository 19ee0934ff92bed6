#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include <frugal_nav/sim/resource_path.hpp>

namespace frugal_nav::sim {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> splitPathList(const char* list) {
  std::vector<std::string> folders;
  std::stringstream stream(list == nullptr ? "" : list);
  for (std::string folder; std::getline(stream, folder, ':');) {
    if (!folder.empty()) folders.push_back(folder);
  }
  return folders;
}

std::optional<std::string> existing(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return std::nullopt;
  return path.lexically_normal().string();
}

bool isPackage(const fs::path& folder, const std::string& name) {
  std::ifstream manifest(folder / "package.xml");
  if (!manifest) return false;
  if (folder.filename() == name) return true;
  const std::string text((std::istreambuf_iterator<char>(manifest)), std::istreambuf_iterator<char>());
  return text.find("<name>" + name + "</name>") != std::string::npos;
}

/// The rest of the text behind a prefix, if it has it.
std::optional<std::string> after(const std::string& prefix, const std::string& text) {
  if (text.compare(0, prefix.size(), prefix) != 0) return std::nullopt;
  return text.substr(prefix.size());
}

}  // namespace

ResourcePath::ResourcePath(std::vector<std::string> model_folders, std::vector<std::string> package_folders)
    : model_folders_(std::move(model_folders)), package_folders_(std::move(package_folders)) {}

ResourcePath ResourcePath::fromEnvironment() {
  return {splitPathList(std::getenv("GAZEBO_MODEL_PATH")), splitPathList(std::getenv("ROS_PACKAGE_PATH"))};
}

ResourcePath ResourcePath::withWorld(const std::string& world_path) const {
  ResourcePath wider = *this;
  const fs::path folder = fs::absolute(world_path).lexically_normal().parent_path();
  for (const fs::path& added : {folder, folder / "models", folder.parent_path() / "models"}) {
    wider.model_folders_.push_back(added.string());
  }
  return wider;
}

std::optional<std::string> ResourcePath::findInModels(const std::string& path) const {
  for (const fs::path folder : model_folders_) {
    if (auto found = existing(folder / path)) return found;
  }
  return std::nullopt;
}

std::optional<std::string> ResourcePath::findInPackages(const std::string& path) const {
  const auto slash = std::min(path.find('/'), path.size());
  const std::string name = path.substr(0, slash);
  const std::string rest = path.substr(std::min(slash + 1, path.size()));
  for (const fs::path folder : package_folders_) {
    if (auto found = existing(folder / name / rest)) return found;
    if (!isPackage(folder, name)) continue;
    if (auto found = existing(folder / rest)) return found;
  }
  return std::nullopt;
}

std::optional<std::string> ResourcePath::find(const std::string& uri, const std::string& base_folder) const {
  if (uri.empty()) return std::nullopt;
  if (const auto path = after("model://", uri)) return findInModels(*path);
  if (const auto path = after("package://", uri)) return findInPackages(*path);
  std::string path = after("file://", uri).value_or(uri);
  if (path.find("://") != std::string::npos) return std::nullopt;
  std::replace(path.begin(), path.end(), '\\', '/');
  if (auto found = existing(fs::path(base_folder) / path))
    return found;  // an absolute path replaces the base
  return fs::path(path).is_absolute() ? std::nullopt : findInModels(path);
}

std::optional<std::string> findTexture(const std::string& name, const std::string& mesh_folder,
                                       const ResourcePath& resources) {
  if (auto found = resources.find(name, mesh_folder)) return found;
  std::string path = name;
  std::replace(path.begin(), path.end(), '\\', '/');
  const fs::path base_name = fs::path(path).filename();
  if (base_name.empty()) return std::nullopt;
  fs::path folder(mesh_folder);
  constexpr int kLevels = 3;  // MODEL/meshes/visual/ is the deepest layout in use
  for (int level = 0; level < kLevels && !folder.empty(); ++level, folder = folder.parent_path()) {
    for (const char* sub : {".", "textures", "materials/textures", "materials", "meshes", "images"}) {
      if (auto found = existing(folder / sub / base_name)) return found;
    }
  }
  return std::nullopt;
}

}  // namespace frugal_nav::sim
