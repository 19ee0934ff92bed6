#include <algorithm>
#include <array>
#include <sstream>

#include <frugal_nav/sim/gazebo_materials.hpp>

namespace frugal_nav::sim {
namespace {

struct NamedColor {
  const char* name;
  float r, g, b;
};

// The diffuse colours of Gazebo's gazebo.material; below, the mean colour of its textures.
constexpr std::array<NamedColor, 40> kColors{{
    {"Grey", 0.7F, 0.7F, 0.7F},
    {"Gray", 0.7F, 0.7F, 0.7F},
    {"LightGrey", 0.85F, 0.85F, 0.85F},
    {"DarkGrey", 0.175F, 0.175F, 0.175F},
    {"DarkGray", 0.175F, 0.175F, 0.175F},
    {"White", 1.0F, 1.0F, 1.0F},
    {"FlatBlack", 0.1F, 0.1F, 0.1F},
    {"Black", 0.0F, 0.0F, 0.0F},
    {"Red", 1.0F, 0.0F, 0.0F},
    {"RedBright", 0.87F, 0.26F, 0.07F},
    {"Green", 0.0F, 1.0F, 0.0F},
    {"Blue", 0.0F, 0.0F, 1.0F},
    {"SkyBlue", 0.13F, 0.44F, 0.7F},
    {"Yellow", 1.0F, 1.0F, 0.0F},
    {"ZincYellow", 0.9725F, 0.9529F, 0.2078F},
    {"DarkYellow", 0.7F, 0.7F, 0.0F},
    {"Purple", 1.0F, 0.0F, 1.0F},
    {"DarkMagenta", 0.6F, 0.0F, 0.6F},
    {"Turquoise", 0.0F, 1.0F, 1.0F},
    {"Orange", 1.0F, 0.5088F, 0.0468F},
    {"DarkOrange", 0.7F, 0.3F, 0.0F},
    {"Indigo", 0.33F, 0.0F, 0.5F},
    {"Gold", 0.8F, 0.64869F, 0.12076F},
    {"PioneerBody", 0.5F, 0.0F, 0.0F},
    {"Pioneer2Body", 0.5F, 0.0F, 0.0F},
    {"BuildingFrame", 1.0F, 1.0F, 1.0F},
    {"Residential", 0.35F, 0.35F, 0.35F},
    {"Road", 0.3F, 0.3F, 0.3F},
    {"Pedestrian", 0.55F, 0.53F, 0.5F},
    {"Footway", 0.55F, 0.53F, 0.5F},
    {"Motorway", 0.3F, 0.3F, 0.3F},
    {"Runway", 0.25F, 0.25F, 0.25F},
    {"Wood", 0.6F, 0.45F, 0.3F},
    {"WoodFloor", 0.55F, 0.4F, 0.26F},
    {"WoodPallet", 0.6F, 0.48F, 0.33F},
    {"Bricks", 0.55F, 0.33F, 0.27F},
    {"CeilingTiled", 0.8F, 0.8F, 0.78F},
    {"PaintedWall", 0.8F, 0.78F, 0.72F},
    {"Grass", 0.3F, 0.42F, 0.2F},
    {"EditorPlane", 0.9F, 0.9F, 0.9F},
}};

/// The name without an ending, if it has it.
std::string without(const std::string& ending, const std::string& name) {
  const bool has_it =
      name.size() > ending.size() && name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
  return has_it ? name.substr(0, name.size() - ending.size()) : name;
}

bool readColor(std::istringstream& line, Eigen::Vector3f& color) {
  Eigen::Vector3f read;
  if (!(line >> read.x() >> read.y() >> read.z())) return false;
  color = read.cwiseMax(0.0F).cwiseMin(1.0F);
  return true;
}

void readAttribute(const std::string& text, ScriptMaterial& result) {
  std::istringstream line(text);
  std::string key;
  line >> key;
  if (key == "diffuse") {
    readColor(line, result.material.albedo);
  } else if (key == "emissive") {
    readColor(line, result.material.emission);
  } else if (key == "texture" && result.texture_name.empty()) {
    line >> result.texture_name;
  }
}

}  // namespace

std::optional<Material> gazeboMaterial(const std::string& name) {
  const std::string prefix = "Gazebo/";
  if (name.compare(0, prefix.size(), prefix) != 0) return std::nullopt;
  const std::string full = name.substr(prefix.size());
  const std::string solid = without("Transparent", without("TransparentOverlay", full));
  const std::string color_name = without("Glow", solid);
  const auto* row = std::find_if(kColors.begin(), kColors.end(),
                                 [&](const NamedColor& color) { return color_name == color.name; });
  if (row == kColors.end()) return std::nullopt;
  Material material;
  material.name = name;
  material.albedo = {row->r, row->g, row->b};
  if (color_name != solid) material.emission = material.albedo;
  return material;
}

std::optional<ScriptMaterial> parseMaterialScript(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  std::optional<ScriptMaterial> result;
  int depth = 0;
  for (std::string line; std::getline(lines, line);) {
    line = line.substr(0, line.find("//"));
    std::istringstream words(line);
    std::string keyword;
    std::string material_name;
    if (!result && words >> keyword >> material_name && keyword == "material" && material_name == name) {
      result.emplace();
      result->material.name = name;
      result->material.albedo = {1.0F, 1.0F, 1.0F};  // OGRE's default
    }
    if (!result) continue;
    readAttribute(line, *result);
    depth += static_cast<int>(std::count(line.begin(), line.end(), '{'));
    const auto closed = static_cast<int>(std::count(line.begin(), line.end(), '}'));
    depth -= closed;
    if (depth <= 0 && closed > 0) break;
  }
  return result;
}

}  // namespace frugal_nav::sim
