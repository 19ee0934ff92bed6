#include "flush_to_zero.hpp"

#include <algorithm>
#include <limits>

#include <embree3/rtcore_ray.h>

#include <frugal_nav/sim/lidar.hpp>

namespace frugal_nav::sim {

namespace {

double incrementOf(const LidarParams& params) {
  const bool full_turn = params.field_of_view_rad > 2.0 * M_PI - 1e-4;
  return full_turn ? 2.0 * M_PI / params.beams : params.field_of_view_rad / (params.beams - 1);
}

}  // namespace

Lidar::Lidar(const LidarParams& params, std::uint64_t seed)
    : params_(params), increment_rad_(incrementOf(params)), random_(seed, "lidar") {
  validate(params, "lidar");
  for (int i = 0; i < params.beams; ++i) {
    const double angle = params.angle_min_rad + increment_rad_ * i;
    directions_.emplace_back(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
  }
}

LaserScan Lidar::scan(const RayTracer& tracer, const Eigen::Isometry3d& world_from_laser, Stamp stamp) {
  LaserScan scan;
  scan.stamp = stamp;
  scan.angle_min_rad = params_.angle_min_rad;
  scan.angle_increment_rad = increment_rad_;
  scan.range_min_m = params_.range_min_m;
  scan.range_max_m = params_.range_max_m;
  scan.ranges_m.resize(directions_.size());

  const FlushToZero flush;
  const Eigen::Vector3f origin = world_from_laser.translation().cast<float>();
  const Eigen::Matrix3f rotation = world_from_laser.linear().cast<float>();
  // Room for the noise: a surface just beyond the limit may still be measured within it.
  const auto reach = static_cast<float>(params_.range_max_m * (1.0 + 5.0 * params_.sigma_ratio));
  for (std::size_t first = 0; first < directions_.size(); first += 8) {
    alignas(32) int active[8] = {};
    RTCRayHit8 rays{};
    const std::size_t count = std::min<std::size_t>(8, directions_.size() - first);
    for (std::size_t lane = 0; lane < count; ++lane) {
      const Eigen::Vector2f& beam = directions_[first + lane];
      const Eigen::Vector3f direction = rotation.col(0) * beam.x() + rotation.col(1) * beam.y();
      active[lane] = -1;
      rays.ray.org_x[lane] = origin.x();
      rays.ray.org_y[lane] = origin.y();
      rays.ray.org_z[lane] = origin.z();
      rays.ray.dir_x[lane] = direction.x();
      rays.ray.dir_y[lane] = direction.y();
      rays.ray.dir_z[lane] = direction.z();
      rays.ray.tfar[lane] = reach;
      rays.ray.mask[lane] = ~0U;
      rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
      rays.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    }
    tracer.intersect8(active, rays, true);
    for (std::size_t lane = 0; lane < count; ++lane) {
      const bool hit = rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
      scan.ranges_m[first + lane] =
          measure(hit ? static_cast<double>(rays.ray.tfar[lane]) : std::numeric_limits<double>::infinity());
    }
  }
  return scan;
}

/// One reading of a true range. Every beam draws the same number of random values, so that a change of the
/// scene leaves the other beams' noise as it was.
float Lidar::measure(double range_m) {
  const double noise = random_.normal(1.0);
  if (random_.chance(params_.dropout_probability)) return std::numeric_limits<float>::quiet_NaN();
  if (range_m < params_.range_min_m) return -std::numeric_limits<float>::infinity();
  const double sigma_m = std::max(params_.sigma_min_m, params_.sigma_ratio * range_m);
  const double measured_m = std::isinf(range_m) ? range_m : range_m + sigma_m * noise;
  if (measured_m > params_.range_max_m) return std::numeric_limits<float>::infinity();
  if (measured_m < params_.range_min_m) return -std::numeric_limits<float>::infinity();
  return static_cast<float>(measured_m);
}

}  // namespace frugal_nav::sim
