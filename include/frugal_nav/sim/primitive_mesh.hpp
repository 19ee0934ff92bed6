#pragma once

#include <Eigen/Core>

#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

// Meshes of SDF's simple shapes, centred on their frame as SDF defines them [m]. All triangles have material
// 0; normals point outward; a texture covers each face, side or plane once, as in Gazebo.

/// A box of the given side lengths.
Mesh makeBox(const Eigen::Vector3d& size_m);

/// A cylinder along z. Its corners lie a little outside the true circle, so that the mean radius, which is
/// what a LIDAR measures on average, is the true one.
Mesh makeCylinder(double radius_m, double length_m);

/// A sphere.
Mesh makeSphere(double radius_m);

/// A rectangle through the origin, facing along `normal`; x and y are carried there by the shortest rotation.
Mesh makePlane(const Eigen::Vector2d& size_m, const Eigen::Vector3d& normal);

}  // namespace frugal_nav::sim
