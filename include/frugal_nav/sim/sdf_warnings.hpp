#pragma once

#include <sdf/Element.hh>

#include <frugal_nav/sim/scene_builder.hpp>

namespace frugal_nav::sim {

/// Warns once of each thing in a world that the simulator does not know: plugins, moving joints, sensors,
/// unknown shapes and elements. What only concerns Gazebo's window, physics engine or weather is passed over.
void warnOfUnsimulated(const sdf::ElementPtr& world, SceneBuilder& builder);

}  // namespace frugal_nav::sim
