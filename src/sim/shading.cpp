#include "shading.hpp"

#include <algorithm>
#include <cmath>

#include <embree3/rtcore_ray.h>

namespace frugal_nav::sim {
namespace {

constexpr int kMaxTested = 4;
constexpr float kShadowBias_m = 1e-3F;  // keeps a surface from shadowing itself by rounding
constexpr float kLampRadius_m = 0.1F;   // a lamp's own housing does not shade its light
constexpr float kFarAway_m = 1e4F;
constexpr float kFaintShare = 0.03F;       // of the light at a point: below it a shadow would not be seen
constexpr float kAmbientFromBelow = 0.4F;  // the floor sends back less than the sky and ceiling send

/// Light of one source at a point, before shadows.
struct Arrival {
  float share = 0.0F;  // of the source's colour
  Eigen::Vector3f to_light = Eigen::Vector3f::Zero();
  float distance_m = 0.0F;
};

Arrival arrivalFrom(const Lighting::Source& source, const Eigen::Vector3f& p, const Eigen::Vector3f& normal) {
  if (source.kind == Light::Kind::kDirectional) {
    return {-normal.dot(source.direction), -source.direction, kFarAway_m};
  }
  const Eigen::Vector3f offset = source.position_m - p;
  const float along = normal.dot(offset);
  if (along <= 0.0F) return {};
  const float distance = offset.norm();
  if (distance > source.range_m || distance <= 0.0F) return {};
  const Eigen::Vector3f to_light = offset / distance;
  float share =
      along / (distance * (source.constant + distance * (source.linear + distance * source.quadratic)));
  if (source.kind == Light::Kind::kSpot) {
    const float cone = (-to_light.dot(source.direction) - source.cos_outer) /
                       std::max(1e-4F, source.cos_inner - source.cos_outer);
    const float inside = std::clamp(cone, 0.0F, 1.0F);
    share *= inside * inside * (3.0F - 2.0F * inside);
  }
  return {share, to_light, distance};
}

/// A source chosen for a shadow test at one point.
struct Tested {
  const Lighting::Source* source = nullptr;
  Arrival arrival;
  float strength = 0.0F;
};

/// The light at one point: the strongest sources apart, the others summed.
struct LitPoint {
  std::array<Tested, kMaxTested> tested;
  int count = 0;
  Eigen::Vector3f others = Eigen::Vector3f::Zero();
  Eigen::Vector3f open = Eigen::Vector3f::Zero();  // sources that cast no shadows
};

void insert(LitPoint& point, const Tested& candidate, int limit) {
  int place = point.count;
  while (place > 0 && point.tested[static_cast<std::size_t>(place - 1)].strength < candidate.strength)
    --place;
  if (place >= limit) {
    point.others += candidate.source->color_lx * candidate.arrival.share;
    return;
  }
  if (point.count == limit) {
    const Tested& weakest = point.tested[static_cast<std::size_t>(limit - 1)];
    point.others += weakest.source->color_lx * weakest.arrival.share;
  } else {
    ++point.count;
  }
  for (int i = point.count - 1; i > place; --i) {
    point.tested[static_cast<std::size_t>(i)] = point.tested[static_cast<std::size_t>(i - 1)];
  }
  point.tested[static_cast<std::size_t>(place)] = candidate;
}

LitPoint collect(const Lighting& lighting, const Eigen::Vector3f& p, const Eigen::Vector3f& normal) {
  LitPoint point;
  for (const Lighting::Source& source : lighting.sources()) {
    const Arrival arrival = arrivalFrom(source, p, normal);
    if (arrival.share <= 0.0F) continue;
    if (source.casts_shadows) {
      insert(point, {&source, arrival, arrival.share * source.strength_lx}, lighting.shadowRays());
    } else {
      point.open += source.color_lx * arrival.share;
    }
  }
  return point;
}

/// Which of the points' sources of one rank are hidden by something.
std::array<bool, kLanes> findShadows(const RayTracer& tracer, const ShadePoints& points,
                                     const std::array<LitPoint, kLanes>& lit, int rank, float faint_lx) {
  std::array<bool, kLanes> shadowed{};
  alignas(32) int active[kLanes] = {};
  RTCRay8 rays;
  bool any = false;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (!points.active[lane] || lit[lane].count <= rank) continue;
    const Tested& tested = lit[lane].tested[static_cast<std::size_t>(rank)];
    if (tested.strength < faint_lx) continue;
    any = true;
    active[lane] = -1;
    const Eigen::Vector3f origin = points.position[lane] + kShadowBias_m * points.face_normal[lane];
    rays.org_x[lane] = origin.x();
    rays.org_y[lane] = origin.y();
    rays.org_z[lane] = origin.z();
    rays.dir_x[lane] = tested.arrival.to_light.x();
    rays.dir_y[lane] = tested.arrival.to_light.y();
    rays.dir_z[lane] = tested.arrival.to_light.z();
    rays.tnear[lane] = 0.0F;
    rays.tfar[lane] = std::max(0.0F, tested.arrival.distance_m - kLampRadius_m);
    rays.time[lane] = 0.0F;
    rays.mask[lane] = ~0U;
    rays.flags[lane] = 0;
  }
  if (!any) return shadowed;
  tracer.occluded8(active, rays, true);
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    shadowed[lane] = active[lane] != 0 && rays.tfar[lane] < 0.0F;
  return shadowed;
}

}  // namespace

std::array<Eigen::Vector3f, kLanes> illuminate(const RayTracer& tracer, const Lighting& lighting,
                                               const ShadePoints& points) {
  std::array<LitPoint, kLanes> lit;
  std::array<Eigen::Vector3f, kLanes> result;
  std::array<float, kLanes> arriving{};
  std::array<float, kLanes> sent{};
  int ranks = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (!points.active[lane]) continue;
    lit[lane] = collect(lighting, points.position[lane], points.normal[lane]);
    const float height = 0.5F + 0.5F * points.normal[lane].z();
    result[lane] =
        lighting.ambient_lx() * (kAmbientFromBelow + (1.0F - kAmbientFromBelow) * height) + lit[lane].open;
    ranks = std::max(ranks, lit[lane].count);
  }
  const float faint_lx = kFaintShare * static_cast<float>(lighting.illuminance_lx());
  for (int rank = 0; rank < ranks; ++rank) {
    const std::array<bool, kLanes> shadowed = findShadows(tracer, points, lit, rank, faint_lx);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (!points.active[lane] || lit[lane].count <= rank) continue;
      const Tested& tested = lit[lane].tested[static_cast<std::size_t>(rank)];
      sent[lane] += tested.strength;
      if (shadowed[lane]) continue;
      arriving[lane] += tested.strength;
      result[lane] += tested.source->color_lx * tested.arrival.share;
    }
  }
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (!points.active[lane]) continue;
    const float visible = sent[lane] > 0.0F ? arriving[lane] / sent[lane] : 1.0F;
    result[lane] += visible * lit[lane].others;
  }
  return result;
}

}  // namespace frugal_nav::sim
