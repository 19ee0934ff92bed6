#pragma once

#include <optional>
#include <string>

#include <Eigen/Geometry>
#include <sdf/Actor.hh>
#include <sdf/Light.hh>
#include <sdf/Material.hh>
#include <sdf/Model.hh>
#include <sdf/SemanticPose.hh>

#include <frugal_nav/sim/scene.hpp>
#include <frugal_nav/sim/scene_builder.hpp>

namespace frugal_nav::sim {

// From libsdformat's objects to the scene's. What cannot be used becomes a warning of the builder.

/// A rigid motion in Eigen's terms.
Eigen::Isometry3d toIsometry(const ignition::math::Pose3d& pose);

/// A pose in its parent's frame. One that names an unknown frame counts as relative to the parent.
Eigen::Isometry3d resolvePose(const sdf::SemanticPose& pose, const std::string& owner, SceneBuilder& builder);

/// Adds a model with all its links, nested models and lights.
void addModel(const sdf::Model& model, const Eigen::Isometry3d& world_from_model, SceneBuilder& builder);

/// Adds a light whose parent stands at the given pose.
void addLight(const sdf::Light& light, const Eigen::Isometry3d& world_from_parent, SceneBuilder& builder);

/// Adds a person.
void addActor(const sdf::Actor& actor, SceneBuilder& builder);

/// What a visual's `<material>` says; nothing when it says nothing that is simulated.
std::optional<Surface> readSurface(const sdf::Material& material, const std::string& owner,
                                   SceneBuilder& builder);

}  // namespace frugal_nav::sim
