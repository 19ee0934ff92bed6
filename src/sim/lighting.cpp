#include "flush_to_zero.hpp"
#include "shading.hpp"

#include <algorithm>
#include <cmath>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/sim/lighting.hpp>

namespace frugal_nav::sim {
namespace {

constexpr double kDeskHeight_m = 0.8;
constexpr double kLargestFurniture_m = 30.0;  // what is wider is ground or sky and says nothing of the middle
constexpr int kProbes = 9;                    // along each side of the grid

/// A named light setting: illuminance on a desk, and how much of the scene's lights it uses.
struct Setting {
  double low_lx;
  double high_lx;
  float directional;
  float lamps;
};

Setting settingOf(const std::string& name) {
  if (name == "daylight") return {500.0, 1000.0, 1.0F, 0.3F};
  if (name == "tube") return {1000.0, 2000.0, 0.2F, 1.0F};
  return {10.0, 50.0, 1.0F, 0.1F};
}

Light overheadLight() {
  Light light;
  light.name = "overhead";
  light.kind = Light::Kind::kDirectional;
  light.direction = Eigen::Vector3d(0.3, 0.2, -1.0).normalized();
  return light;
}

Lighting::Source makeSource(const Light& light, const Setting& setting) {
  Lighting::Source source;
  source.kind = light.kind;
  const float weight = light.kind == Light::Kind::kDirectional ? setting.directional : setting.lamps;
  source.color_lx = weight * light.color.cast<float>();
  source.position_m = light.position_m.cast<float>();
  source.direction = light.direction.normalized().cast<float>();
  source.range_m = static_cast<float>(light.range_m);
  source.constant = static_cast<float>(light.attenuation_constant);
  source.linear = static_cast<float>(light.attenuation_linear);
  source.quadratic = static_cast<float>(light.attenuation_quadratic);
  source.cos_inner = static_cast<float>(std::cos(0.5 * light.spot_inner_rad));
  source.cos_outer = static_cast<float>(std::cos(0.5 * light.spot_outer_rad));
  source.casts_shadows = light.casts_shadows;
  source.strength_lx = source.color_lx.maxCoeff();
  return source;
}

/// The horizontal box around what furnishes the world.
Eigen::AlignedBox2d middleOf(const RayTracer& tracer) {
  Eigen::AlignedBox2d middle;
  const Scene& scene = tracer.scene();
  for (std::size_t m = 0; m < scene.models.size(); ++m) {
    for (std::size_t v = 0; v < scene.models[m].visuals.size(); ++v) {
      const Eigen::AlignedBox3d box = tracer.visualBounds(static_cast<int>(m), static_cast<int>(v));
      if (box.isEmpty() || box.sizes().head<2>().maxCoeff() > kLargestFurniture_m) continue;
      middle.extend(Eigen::Vector2d(box.min().head<2>()));
      middle.extend(Eigen::Vector2d(box.max().head<2>()));
    }
  }
  if (middle.isEmpty()) middle = {Eigen::Vector2d(-2.0, -2.0), Eigen::Vector2d(2.0, 2.0)};
  return middle;
}

}  // namespace

Lighting::Lighting(const LightingParams& params, const RayTracer& tracer, std::uint64_t seed)
    : shadow_rays_(params.shadow_rays) {
  validate(params, "lighting");
  const Setting setting = settingOf(params.setting);
  Random random(seed, "lighting");
  const double drawn_lx = random.uniform(setting.low_lx, setting.high_lx);
  const double wanted_lx = params.illuminance_lx > 0.0 ? params.illuminance_lx : drawn_lx;
  const Scene& scene = tracer.scene();
  for (const Light& light : scene.lights) sources_.push_back(makeSource(light, setting));
  if (scene.lights.empty()) sources_.push_back(makeSource(overheadLight(), setting));
  ambient_lx_ = scene.ambient;

  const double found = medianAtDesk(tracer);
  if (found > 0.0) {
    const auto scale = static_cast<float>(wanted_lx / found);
    ambient_lx_ *= scale;
    for (Source& source : sources_) {
      source.color_lx *= scale;
      source.strength_lx *= scale;
    }
  } else {  // no light reaches the middle of this world: it gets an even one
    ambient_lx_ = Eigen::Vector3f::Constant(static_cast<float>(wanted_lx));
  }
  illuminance_lx_ = wanted_lx;
}

double Lighting::measure(const RayTracer& tracer, const Eigen::Vector3d& p_world) const {
  const FlushToZero flush;
  ShadePoints points;
  points.active[0] = true;
  for (int lane = 0; lane < kLanes; ++lane) {  // the others only keep the arithmetic defined
    setLane(points.position, lane, p_world.cast<float>());
    setLane(points.normal, lane, Eigen::Vector3f::UnitZ());
    setLane(points.face_normal, lane, Eigen::Vector3f::UnitZ());
  }
  const Eigen::Vector3f light = getLane(illuminate(tracer, *this, points), 0);
  return static_cast<double>(light.dot(Eigen::Vector3f(0.2126F, 0.7152F, 0.0722F)));  // luminance, Rec. 709
}

double Lighting::medianAtDesk(const RayTracer& tracer) const {
  const Eigen::AlignedBox2d middle = middleOf(tracer);
  std::vector<double> found;
  for (int i = 0; i < kProbes; ++i) {
    for (int k = 0; k < kProbes; ++k) {
      // The middle 60 % of each side: the rest is mostly wall.
      const Eigen::Vector2d share(0.2 + 0.6 * i / (kProbes - 1), 0.2 + 0.6 * k / (kProbes - 1));
      const Eigen::Vector2d p = middle.min() + share.cwiseProduct(middle.sizes());
      found.push_back(measure(tracer, {p.x(), p.y(), kDeskHeight_m}));
    }
  }
  std::nth_element(found.begin(), found.begin() + found.size() / 2, found.end());
  return found[found.size() / 2];
}

}  // namespace frugal_nav::sim
