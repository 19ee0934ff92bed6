#pragma once

#include "surfaces.hpp"

#include <array>

#include <Eigen/Core>

#include <frugal_nav/sim/lighting.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>

namespace frugal_nav::sim {

constexpr int kLanes = 8;

/// Eight points to light; a lane that is not active holds nothing.
struct ShadePoints {
  std::array<bool, kLanes> active{};
  std::array<Eigen::Vector3f, kLanes> position;
  std::array<Eigen::Vector3f, kLanes> normal;       ///< for shading, unit length
  std::array<Eigen::Vector3f, kLanes> face_normal;  ///< shadow rays start on its side
};

/// Illuminance [lx] at eight points, after Lambert, with shadow rays to the lights that are strongest there.
/// Weaker lights are dimmed by the share of the tested light that arrives.
std::array<Eigen::Vector3f, kLanes> illuminate(const RayTracer& tracer, const Lighting& lighting,
                                               const ShadePoints& points);

}  // namespace frugal_nav::sim
