#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <frugal_nav/sim/ray_tracer.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

/// Linear light of an sRGB value in [0, 1] (IEC 61966-2-1).
float linearFromSrgb(float srgb);
/// sRGB value in [0, 1] of linear light.
float srgbFromLinear(float linear);

/// How a point of a surface reflects and shines, linear.
struct SurfacePoint {
  Eigen::Vector3f albedo;
  Eigen::Vector3f emission;
  Eigen::Vector3f normal_world;  ///< for shading, unit length, on the side of the ray
  Eigen::Vector3f face_normal;   ///< the triangle's, on the side of the ray
};

/// The materials of a scene, ready for shading: linear colours, and textures as pyramids so that far floors
/// do not shimmer.
class Surfaces {
 public:
  explicit Surfaces(const Scene& scene);

  /// The surface that a lane of a packet hit, which the hit names; `footprint_m` is how wide a pixel is
  /// there, across the ray.
  SurfacePoint at(const SurfaceHit& hit, const RTCRayHit8& rays, int lane, float footprint_m) const;

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<std::uint32_t> rgbx;  // sRGB: one load a texel
  };
  struct Paint {
    Eigen::Vector3f albedo;
    Eigen::Vector3f emission;
    int texture = -1;
  };

  Eigen::Vector3f sampleTexture(const std::vector<Level>& levels, const Eigen::Vector2f& uv, float lod) const;
  Eigen::Vector3f sampleLevel(const Level& level, float u, float v) const;
  std::vector<Level> pyramid(const Texture& texture) const;
  Eigen::Vector3f linearTexel(std::uint32_t texel) const {
    return {linear_[texel & 255U], linear_[texel >> 8U & 255U], linear_[texel >> 16U & 255U]};
  }

  const Scene& scene_;
  std::array<float, 256> linear_;
  std::vector<Paint> paints_;
  std::vector<std::vector<Level>> textures_;
  std::vector<std::vector<float>> log2_uv_per_m_;  // by mesh and triangle; empty for a mesh without uvs
};

}  // namespace frugal_nav::sim
