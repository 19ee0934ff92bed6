#pragma once

#include <Eigen/Geometry>
#include <embree3/rtcore.h>

#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

/// A committed triangle geometry with the mesh's vertices moved by a pose; the caller releases it.
RTCGeometry makeGeometry(RTCDevice device, const Mesh& mesh, const Eigen::Isometry3d& pose);

/// Throws ConfigError, naming the model, when a visual's mesh or one of its vertices does not exist.
void checkMesh(const Scene& scene, const Model& model, const Visual& visual);

}  // namespace frugal_nav::sim
