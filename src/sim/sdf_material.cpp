#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include <sdf/Element.hh>
#include <sdf/Pbr.hh>

#include <frugal_nav/sim/gazebo_materials.hpp>
#include <frugal_nav/sim/sdf_model.hpp>

namespace frugal_nav::sim {
namespace {

namespace fs = std::filesystem;

Eigen::Vector3f toRgb(const ignition::math::Color& color) {
  return Eigen::Vector3f(color.R(), color.G(), color.B()).cwiseMax(0.0F).cwiseMin(1.0F);
}

std::string folderOf(const std::string& path) { return fs::path(path).parent_path().string(); }

/// The files and folders that a `<script>` names, as far as they exist.
std::vector<fs::path> scriptPlaces(const sdf::ElementPtr& script, const std::string& base_folder,
                                   const ResourcePath& resources) {
  std::vector<fs::path> places;
  if (!script->HasElement("uri")) return places;
  for (sdf::ElementPtr uri = script->GetElement("uri"); uri; uri = uri->GetNextElement("uri")) {
    if (const auto place = resources.find(uri->Get<std::string>(), base_folder)) places.emplace_back(*place);
  }
  return places;
}

/// The material scripts at those places, in the order of their names.
std::vector<fs::path> scriptFiles(const std::vector<fs::path>& places) {
  std::vector<fs::path> files;
  for (const fs::path& place : places) {
    if (!fs::is_directory(place)) {
      files.push_back(place);
      continue;
    }
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(place, error)) {
      if (entry.path().extension() == ".material") files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

int scriptTexture(const std::string& name, const fs::path& script, const std::vector<fs::path>& places,
                  const std::string& owner, SceneBuilder& builder) {
  for (const fs::path& place : places) {
    if (fs::exists(place / name)) return builder.addTexture((place / name).string(), "", owner);
  }
  return builder.addTexture(name, script.parent_path().string(), owner);
}

/// A material script's material: one of Gazebo's own, or one of a script that the model brings.
std::optional<Material> readScript(const sdf::Material& material, const std::string& owner,
                                   SceneBuilder& builder) {
  const std::string name = material.ScriptName();
  if (auto known = gazeboMaterial(name)) return known;
  const auto places = scriptPlaces(material.Element()->GetElement("script"), folderOf(material.FilePath()),
                                   builder.resources());
  for (const fs::path& file : scriptFiles(places)) {
    std::ifstream stream(file);
    const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    auto found = parseMaterialScript(text, name);
    if (!found) continue;
    builder.noteFile(file.string());
    if (!found->texture_name.empty()) {
      found->material.texture = scriptTexture(found->texture_name, file, places, owner, builder);
    }
    return found->material;
  }
  builder.warn("material script " + name + " of " + owner + " is not simulated");
  return std::nullopt;
}

std::string albedoMap(const sdf::Material& material) {
  const sdf::Pbr* pbr = material.PbrMaterial();
  if (pbr == nullptr) return {};
  for (const auto type : {sdf::PbrWorkflowType::METAL, sdf::PbrWorkflowType::SPECULAR}) {
    const sdf::PbrWorkflow* workflow = pbr->Workflow(type);
    if (workflow != nullptr && !workflow->AlbedoMap().empty()) return workflow->AlbedoMap();
  }
  return {};
}

}  // namespace

std::optional<Surface> readSurface(const sdf::Material& material, const std::string& owner,
                                   SceneBuilder& builder) {
  const sdf::ElementPtr element = material.Element();
  if (!element) return std::nullopt;
  Surface surface;
  bool says_something = false;
  if (!material.ScriptName().empty()) {
    if (const auto script = readScript(material, owner, builder)) {
      surface.material = *script;
      surface.has_color = says_something = true;
    }
  }
  const std::string map = albedoMap(material);
  if (!map.empty()) {
    surface.material.texture = builder.addTexture(map, folderOf(material.FilePath()), owner);
    if (surface.material.texture >= 0) {
      surface.material.albedo = Eigen::Vector3f::Ones();
      says_something = true;
    }
  }
  if (element->HasElement("diffuse") || element->HasElement("ambient")) {
    surface.material.albedo = toRgb(element->HasElement("diffuse") ? material.Diffuse() : material.Ambient());
    surface.has_color = says_something = true;
  }
  if (element->HasElement("emissive")) {
    surface.material.emission = toRgb(material.Emissive());
    says_something = true;
  }
  return says_something ? std::optional<Surface>(surface) : std::nullopt;
}

}  // namespace frugal_nav::sim
