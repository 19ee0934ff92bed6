#include "shading.hpp"

#include <algorithm>
#include <cmath>

#include <embree3/rtcore_ray.h>

namespace frugal_nav::sim {
namespace {

constexpr std::size_t kMaxTested = 4;
constexpr float kShadowBias_m = 1e-3F;  // keeps a surface from shadowing itself by rounding
constexpr float kLampRadius_m = 0.1F;   // a lamp's own housing does not shade its light
constexpr float kFarAway_m = 1e4F;
constexpr float kFaintShare = 0.03F;       // of the world's light: below it a shadow would not be seen
constexpr float kAmbientFromBelow = 0.5F;  // the floor sends back less than the sky and ceiling send

using Indices = Eigen::Array<int, kLanes, 1>;

Lanes dot(const Lanes3& a, const Eigen::Vector3f& b) { return a[0] * b.x() + a[1] * b.y() + a[2] * b.z(); }
Lanes dot(const Lanes3& a, const Lanes3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// The share of a source's colour that arrives at each point, before shadows.
Lanes shareOf(const Lighting::Source& source, const ShadePoints& points) {
  if (source.kind == Light::Kind::kDirectional) return (-dot(points.normal, source.direction)).max(0.0F);
  const Lanes3 offset = {source.position_m.x() - points.position[0],
                         source.position_m.y() - points.position[1],
                         source.position_m.z() - points.position[2]};
  const Lanes squared = dot(offset, offset).max(1e-6F);
  const Lanes distance = squared.sqrt();
  const Lanes attenuation = source.constant + distance * (source.linear + distance * source.quadratic);
  Lanes share = dot(points.normal, offset).max(0.0F) / (distance * attenuation);
  if (source.kind == Light::Kind::kSpot) {
    const float width = std::max(1e-4F, source.cos_inner - source.cos_outer);
    const Lanes cone = (-dot(offset, source.direction) / distance - source.cos_outer) / width;
    const Lanes inside = cone.max(0.0F).min(1.0F);
    share *= inside * inside * (3.0F - 2.0F * inside);
  }
  return (squared <= source.range_m * source.range_m).select(share, Lanes::Zero());
}

/// The light at eight points: everything that casts shadows, and apart the strongest sources of each point,
/// by falling strength.
struct Arrivals {
  Lanes3 all = {Lanes::Zero(), Lanes::Zero(), Lanes::Zero()};
  Lanes3 open = {Lanes::Zero(), Lanes::Zero(), Lanes::Zero()};  // from sources that cast no shadows
  std::size_t ranks = 0;
  std::array<Lanes, kMaxTested> strength_lx;
  std::array<Lanes, kMaxTested> share;
  std::array<Indices, kMaxTested> source;
};

/// Sorts a source in among the strongest: in each lane the weaker of two moves on to the next rank.
void insert(Arrivals& arrivals, int index, Lanes share, Lanes strength_lx) {
  Indices source = Indices::Constant(index);
  for (std::size_t rank = 0; rank < arrivals.ranks; ++rank) {
    const auto stronger = (strength_lx > arrivals.strength_lx[rank]).eval();
    const Lanes weaker_strength = stronger.select(arrivals.strength_lx[rank], strength_lx);
    const Lanes weaker_share = stronger.select(arrivals.share[rank], share);
    const Indices weaker_source = stronger.select(arrivals.source[rank], source);
    arrivals.strength_lx[rank] = stronger.select(strength_lx, arrivals.strength_lx[rank]);
    arrivals.share[rank] = stronger.select(share, arrivals.share[rank]);
    arrivals.source[rank] = stronger.select(source, arrivals.source[rank]);
    strength_lx = weaker_strength;
    share = weaker_share;
    source = weaker_source;
  }
}

void add(Lanes3& sum, const Lanes& share, const Eigen::Vector3f& color) {
  for (int i = 0; i < 3; ++i) sum[static_cast<std::size_t>(i)] += share * color[i];
}

Arrivals collect(const Lighting& lighting, const ShadePoints& points) {
  Arrivals arrivals;
  const std::vector<Lighting::Source>& sources = lighting.sources();
  arrivals.ranks = std::min({kMaxTested, static_cast<std::size_t>(lighting.shadowRays()), sources.size()});
  for (std::size_t rank = 0; rank < arrivals.ranks; ++rank) {
    arrivals.strength_lx[rank].setZero();
    arrivals.share[rank].setZero();
    arrivals.source[rank].setZero();
  }
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const Lanes share = shareOf(sources[i], points);
    add(sources[i].casts_shadows ? arrivals.all : arrivals.open, share, sources[i].color_lx);
    if (sources[i].casts_shadows) {
      insert(arrivals, static_cast<int>(i), share, share * sources[i].strength_lx);
    }
  }
  return arrivals;
}

void setShadowRay(const Lighting::Source& source, const ShadePoints& points, int lane, RTCRay8& rays) {
  const Eigen::Vector3f origin =
      getLane(points.position, lane) + kShadowBias_m * getLane(points.face_normal, lane);
  Eigen::Vector3f direction = -source.direction;
  float length_m = kFarAway_m;
  if (source.kind != Light::Kind::kDirectional) {
    direction = source.position_m - origin;
    const float distance = direction.norm();
    direction *= 1.0F / std::max(distance, 1e-6F);
    length_m = std::max(0.0F, distance - kLampRadius_m);
  }
  rays.org_x[lane] = origin.x();
  rays.org_y[lane] = origin.y();
  rays.org_z[lane] = origin.z();
  rays.dir_x[lane] = direction.x();
  rays.dir_y[lane] = direction.y();
  rays.dir_z[lane] = direction.z();
  rays.tnear[lane] = 0.0F;
  rays.tfar[lane] = length_m;
  rays.time[lane] = 0.0F;
  rays.mask[lane] = ~0U;
  rays.flags[lane] = 0;
}

/// How much of the points' sources of one rank arrives: 1 where nothing is in the way, 0 in shadow.
Lanes visibility(const RayTracer& tracer, const Lighting& lighting, const ShadePoints& points,
                 const Arrivals& arrivals, std::size_t rank) {
  const float faint_lx = kFaintShare * static_cast<float>(lighting.illuminance_lx());
  alignas(32) int active[kLanes] = {};
  RTCRay8 rays;
  bool any = false;
  for (int lane = 0; lane < kLanes; ++lane) {
    if (!points.active[static_cast<std::size_t>(lane)] || arrivals.strength_lx[rank][lane] <= faint_lx)
      continue;
    const auto source = static_cast<std::size_t>(arrivals.source[rank][lane]);
    setShadowRay(lighting.sources()[source], points, lane, rays);
    active[lane] = -1;
    any = true;
  }
  Lanes visible = Lanes::Ones();
  if (!any) return visible;
  tracer.occluded8(active, rays, true);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (active[lane] != 0 && rays.tfar[lane] < 0.0F) visible[lane] = 0.0F;
  }
  return visible;
}

}  // namespace

Lanes3 illuminate(const RayTracer& tracer, const Lighting& lighting, const ShadePoints& points) {
  const Arrivals arrivals = collect(lighting, points);
  Lanes3 tested = {Lanes::Zero(), Lanes::Zero(), Lanes::Zero()};   // light of the tested sources, unshadowed
  Lanes3 arrived = {Lanes::Zero(), Lanes::Zero(), Lanes::Zero()};  // what of it gets through
  for (std::size_t rank = 0; rank < arrivals.ranks; ++rank) {
    const Lanes visible = visibility(tracer, lighting, points, arrivals, rank);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Eigen::Vector3f light =
          lighting.sources()[static_cast<std::size_t>(arrivals.source[rank][lane])].color_lx *
          arrivals.share[rank][lane];
      for (std::size_t i = 0; i < 3; ++i) {
        tested[i][lane] += light[static_cast<int>(i)];
        arrived[i][lane] += visible[lane] * light[static_cast<int>(i)];
      }
    }
  }
  const Lanes sent = (tested[0] + tested[1] + tested[2]).max(1e-12F);
  const Lanes through =
      arrivals.ranks > 0 ? Lanes((arrived[0] + arrived[1] + arrived[2]) / sent) : Lanes(Lanes::Ones());
  const Lanes sky = kAmbientFromBelow + (1.0F - kAmbientFromBelow) * (0.5F + 0.5F * points.normal[2]);
  Lanes3 result;
  for (std::size_t i = 0; i < 3; ++i) {
    const Lanes others = (arrivals.all[i] - tested[i]).max(0.0F);
    result[i] =
        lighting.ambient_lx()[static_cast<int>(i)] * sky + arrivals.open[i] + arrived[i] + through * others;
  }
  return result;
}

}  // namespace frugal_nav::sim
