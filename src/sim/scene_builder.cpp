#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <stdexcept>

#include <frugal_nav/sim/scene_builder.hpp>

namespace frugal_nav::sim {
namespace {

bool isEqual(const Material& a, const Material& b) {
  return a.name == b.name && a.albedo == b.albedo && a.emission == b.emission && a.texture == b.texture;
}

/// A text that is equal for equal numbers only.
std::string exact(const Eigen::Vector3d& v) {
  std::ostringstream text;
  text << std::hexfloat << v.x() << ' ' << v.y() << ' ' << v.z();
  return text.str();
}

}  // namespace

void SceneBuilder::warn(const std::string& text) {
  if (std::find(warnings_.begin(), warnings_.end(), text) == warnings_.end()) warnings_.push_back(text);
}

void SceneBuilder::warnMissing(const std::string& text) {
  is_complete_ = false;
  warn(text);
}

void SceneBuilder::noteFile(const std::string& path) {
  if (std::find(files_.begin(), files_.end(), path) == files_.end()) files_.push_back(path);
}

int SceneBuilder::addMaterial(const Material& material) {
  auto& all = scene.materials;
  const auto same =
      std::find_if(all.begin(), all.end(), [&](const Material& other) { return isEqual(material, other); });
  if (same != all.end()) return static_cast<int>(same - all.begin());
  all.push_back(material);
  return static_cast<int>(all.size()) - 1;
}

int SceneBuilder::addMesh(Mesh mesh) {
  scene.meshes.push_back(std::move(mesh));
  return static_cast<int>(scene.meshes.size()) - 1;
}

int SceneBuilder::addPrimitive(const std::string& key, const std::function<Mesh()>& make,
                               const Material& material) {
  const int material_index = addMaterial(material);
  const std::string full_key = key + ' ' + std::to_string(material_index);
  const auto known = mesh_by_key_.find(full_key);
  if (known != mesh_by_key_.end()) return known->second;
  Mesh mesh = make();
  mesh.triangle_material.assign(mesh.triangles.size(), material_index);
  return mesh_by_key_[full_key] = addMesh(std::move(mesh));
}

int SceneBuilder::addTexture(const std::string& uri, const std::string& base_folder,
                             const std::string& owner) {
  const auto path = findTexture(uri, base_folder, resources_);
  if (!path) {
    warnMissing("texture " + uri + " of " + owner + " is missing");
    return -1;
  }
  const auto known = texture_by_path_.find(*path);
  if (known != texture_by_path_.end()) return known->second;
  noteFile(*path);
  int index = -1;
  if (auto texture = readTexture(*path)) {
    index = static_cast<int>(scene.textures.size());
    scene.textures.push_back(std::move(*texture));
  } else {
    warn("texture " + *path + " of " + owner + " is no image that can be read");
  }
  return texture_by_path_[*path] = index;
}

const MeshFile* SceneBuilder::readOnce(const std::string& path, const Submesh& submesh) {
  const auto [entry, is_new] =
      mesh_files_.emplace(FileKey{path, submesh.name, submesh.is_centered}, std::nullopt);
  if (is_new) {
    try {
      MeshFile file = readMeshFile(path, submesh, resources_);
      for (Material& material : file.materials) {
        if (material.texture < 0) continue;
        // The file's textures join the scene's; files that share an image share the texture.
        Texture& texture = file.textures[static_cast<std::size_t>(material.texture)];
        const auto known = texture_by_path_.find(texture.name);
        if (known == texture_by_path_.end()) {
          texture_by_path_[texture.name] = static_cast<int>(scene.textures.size());
          scene.textures.push_back(texture);
        }
        material.texture = texture_by_path_[texture.name];
      }
      file.textures.clear();
      for (const std::string& warning : file.warnings) warnMissing(warning);
      for (const std::string& read : file.files) noteFile(read);
      entry->second = std::move(file);
    } catch (const std::runtime_error& error) {
      noteFile(path);
      warn(error.what());
    }
  }
  return entry->second ? &*entry->second : nullptr;
}

std::vector<int> SceneBuilder::materialsOf(const MeshFile& file, const std::optional<Surface>& surface) {
  std::vector<int> indices;
  for (Material material : file.materials) {
    if (surface && surface->material.texture >= 0) {
      material = surface->material;
    } else if (surface) {
      // As in Gazebo, a visual's colour replaces that of the file and leaves the texture.
      if (surface->has_color) material.albedo = surface->material.albedo;
      if (!surface->material.emission.isZero()) material.emission = surface->material.emission;
      material.name = surface->material.name;
    }
    indices.push_back(addMaterial(material));
  }
  return indices;
}

std::optional<int> SceneBuilder::addMeshFile(const std::string& uri, const std::string& base_folder,
                                             const Submesh& submesh, const Eigen::Vector3d& scale,
                                             const std::optional<Surface>& surface,
                                             const std::string& owner) {
  const auto path = resources_.find(uri, base_folder);
  if (!path) {
    warnMissing("mesh " + uri + " of " + owner + " is missing");
    return std::nullopt;
  }
  if (!scale.allFinite() || scale.prod() == 0.0) {
    warn("mesh " + uri + " of " + owner + " has a scale of zero");
    return std::nullopt;
  }
  const MeshFile* file = readOnce(*path, submesh);
  if (file == nullptr) return std::nullopt;

  const std::string key =
      *path + '\n' + submesh.name + (submesh.is_centered ? "\ncentred " : "\n") + exact(scale);
  const std::vector<int> materials = materialsOf(*file, surface);
  std::string full_key = key;
  for (const int material : materials) full_key += ' ' + std::to_string(material);
  const auto known = mesh_by_key_.find(full_key);
  if (known != mesh_by_key_.end()) return known->second;

  Mesh mesh = file->mesh;
  scaleMesh(mesh, scale);
  for (int& material : mesh.triangle_material) material = materials[static_cast<std::size_t>(material)];
  return mesh_by_key_[full_key] = addMesh(std::move(mesh));
}

}  // namespace frugal_nav::sim
