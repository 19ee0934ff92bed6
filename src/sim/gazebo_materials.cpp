#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>
#include <vector>

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

/// The words and braces of a script, without its comments.
std::vector<std::string> tokensOf(const std::string& text) {
  std::vector<std::string> tokens;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line = line.substr(0, line.find("//"));
    std::string spaced;
    for (const char c : line) spaced += c == '{' || c == '}' ? std::string{' ', c, ' '} : std::string{c};
    std::istringstream words(spaced);
    for (std::string word; words >> word;) tokens.push_back(word);
  }
  return tokens;
}

/// The three numbers from a token on; the colour stays when there are none ("diffuse vertexcolour").
void readColor(const std::vector<std::string>& tokens, std::size_t first, Eigen::Vector3f& color) {
  Eigen::Vector3f read;
  for (std::size_t i = 0; i < 3; ++i) {
    char* end = nullptr;
    if (first + i >= tokens.size()) return;
    read[static_cast<int>(i)] = std::strtof(tokens[first + i].c_str(), &end);
    if (end == tokens[first + i].c_str()) return;
  }
  color = read.cwiseMax(0.0F).cwiseMin(1.0F);
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
  const std::vector<std::string> tokens = tokensOf(text);
  std::size_t i = 0;
  while (i + 1 < tokens.size() && !(tokens[i] == "material" && tokens[i + 1] == name)) ++i;
  if (i + 1 >= tokens.size()) return std::nullopt;

  ScriptMaterial result;
  result.material.name = name;
  result.material.albedo = {1.0F, 1.0F, 1.0F};  // OGRE's default
  int depth = 0;
  for (i += 2; i < tokens.size(); ++i) {
    if (tokens[i] == "{") ++depth;
    if (tokens[i] == "}" && --depth <= 0) break;
    if (tokens[i] == "diffuse") readColor(tokens, i + 1, result.material.albedo);
    if (tokens[i] == "emissive") readColor(tokens, i + 1, result.material.emission);
    if (tokens[i] == "texture" && result.texture_name.empty() && i + 1 < tokens.size()) {
      result.texture_name = tokens[i + 1];
    }
  }
  return result;
}

}  // namespace frugal_nav::sim
