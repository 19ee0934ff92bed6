#pragma once

#include "person_look.hpp"

#include <frugal_nav/sim/people.hpp>

namespace frugal_nav::sim {

/// Adds the parts of a body to the scene: textures, materials, meshes and a model whose visuals stand at
/// their joints' origins, not yet posed.
PersonBody addBody(const PersonLook& look, const std::string& name, Scene& scene);

}  // namespace frugal_nav::sim
