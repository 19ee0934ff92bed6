#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::sim {

/// How bright a world is.
struct LightingParams {
  std::string setting = "daylight";
  double illuminance_lx = 0.0;
  int shadow_rays = 2;

  template <class Visitor>
  void fields(Visitor&& visit) {
    const double infinity = std::numeric_limits<double>::infinity();
    visit("setting", setting,
          Field{"", "daylight (500-1000 lx, sun and windows), dim (10-50 lx), tube (1000-2000 lx, lamps)",
                -infinity, infinity, "daylight|dim|tube"});
    visit(
        "illuminance_lx", illuminance_lx,
        Field{"lx", "illuminance on a desk; 0 draws it from the setting's range by the seed", 0.0, 100000.0});
    visit("shadow_rays", shadow_rays,
          Field{"", "lights tested for shadows at each point, the strongest there first: the cost of a frame",
                0, 4});
  }
};

/// The lights of a scene in lux: its relative lights, weighted by the setting and scaled so that the median
/// illuminance on a horizontal plane 0.8 m above the floor, over a grid in the middle of the world, is the
/// wanted one. A scene without lights gets one overhead.
class Lighting {
 public:
  /// A light ready for shading.
  struct Source {
    Light::Kind kind = Light::Kind::kPoint;
    Eigen::Vector3f color_lx;  ///< illuminance at no distance, facing it
    Eigen::Vector3f position_m;
    Eigen::Vector3f direction;  ///< the way the light travels
    float strength_lx = 0.0F;   ///< the largest channel of color_lx
    float range_m = 0.0F;
    float constant = 1.0F;
    float linear = 0.0F;
    float quadratic = 0.0F;
    float cos_inner = 1.0F;
    float cos_outer = 0.0F;
    bool casts_shadows = true;
  };

  /// Measures the scene by ray tracing; throws ConfigError on parameters out of range.
  Lighting(const LightingParams& params, const RayTracer& tracer, std::uint64_t seed);

  /// The illuminance asked for [lx].
  double illuminance_lx() const { return illuminance_lx_; }
  const std::vector<Source>& sources() const { return sources_; }
  /// Illuminance from everywhere at once [lx].
  const Eigen::Vector3f& ambient_lx() const { return ambient_lx_; }
  int shadowRays() const { return shadow_rays_; }

  /// Illuminance of a horizontal plane at a point, shadows included [lx].
  double measure(const RayTracer& tracer, const Eigen::Vector3d& p_world) const;

 private:
  double medianAtDesk(const RayTracer& tracer) const;

  std::vector<Source> sources_;
  Eigen::Vector3f ambient_lx_ = Eigen::Vector3f::Zero();
  double illuminance_lx_ = 0.0;
  int shadow_rays_ = 2;
};

}  // namespace frugal_nav::sim
