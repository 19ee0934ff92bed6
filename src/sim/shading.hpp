#pragma once

#include <array>

#include <Eigen/Core>

#include <frugal_nav/sim/lighting.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>

namespace frugal_nav::sim {

constexpr int kLanes = 8;
/// One number for each ray of a packet: shading works on all eight at once.
using Lanes = Eigen::Array<float, kLanes, 1>;
/// One vector or colour for each ray of a packet.
using Lanes3 = std::array<Lanes, 3>;

inline void setLane(Lanes3& lanes, int lane, const Eigen::Vector3f& value) {
  for (int i = 0; i < 3; ++i) lanes[static_cast<std::size_t>(i)][lane] = value[i];
}
inline Eigen::Vector3f getLane(const Lanes3& lanes, int lane) {
  return {lanes[0][lane], lanes[1][lane], lanes[2][lane]};
}

/// Eight points to light; the values of a lane that is not active do not matter.
struct ShadePoints {
  std::array<bool, kLanes> active{};
  Lanes3 position;
  Lanes3 normal;       ///< for shading, unit length
  Lanes3 face_normal;  ///< shadow rays start on its side
};

/// Illuminance [lx] at eight points, after Lambert, with shadow rays to the lights that are strongest there.
/// Weaker lights are dimmed by the share of the tested light that arrives.
Lanes3 illuminate(const RayTracer& tracer, const Lighting& lighting, const ShadePoints& points);

}  // namespace frugal_nav::sim
