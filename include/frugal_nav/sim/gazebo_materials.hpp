#pragma once

#include <optional>
#include <string>

#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

/// One of Gazebo's own materials ("Gazebo/Grey"), which worlds name without bringing the script. Textured
/// ones (Wood, Grass, ...) have their mean colour. Nothing for an unknown name.
std::optional<Material> gazeboMaterial(const std::string& name);

/// What is used of an OGRE material script: the colours and the first texture's file name.
struct ScriptMaterial {
  Material material;
  std::string texture_name;  ///< empty without a texture
};

/// The named material of the script's text (`material NAME { technique { pass { diffuse R G B ... } } }`).
/// Nothing when it is not in there.
std::optional<ScriptMaterial> parseMaterialScript(const std::string& text, const std::string& name);

}  // namespace frugal_nav::sim
