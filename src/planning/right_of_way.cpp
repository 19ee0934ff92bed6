#include <algorithm>
#include <cmath>
#include <limits>

#include <frugal_nav/planning/path_shape.hpp>
#include <frugal_nav/planning/right_of_way.hpp>

namespace frugal_nav {
namespace {

constexpr double kStep_m = 0.05;
constexpr double kStep_s = 0.1;

struct PlaceInTime {
  Eigen::Vector2d p;
  double s_m;
  double arrival_s;
};

/// When a robot that speeds up to its cruising speed has driven a way.
double arrivalAfter(double way_m, double speed_mps, const RightOfWayParams& params) {
  const double begin = std::min(speed_mps, params.cruise_mps);
  const double ramp_s = (params.cruise_mps - begin) / params.accel_mps2;
  const double ramp_m = 0.5 * (params.cruise_mps + begin) * ramp_s;
  if (way_m >= ramp_m) return ramp_s + (way_m - ramp_m) / params.cruise_mps;
  return (std::sqrt(begin * begin + 2.0 * params.accel_mps2 * way_m) - begin) / params.accel_mps2;
}

std::vector<PlaceInTime> placesAlong(const Path2& path, double speed_mps, const RightOfWayParams& params) {
  std::vector<PlaceInTime> places;
  if (path.empty()) return places;
  places.push_back({path.front().position(), 0.0, 0.0});
  double s_m = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Eigen::Vector2d way = path[i].position() - path[i - 1].position();
    const int pieces = std::max(1, static_cast<int>(std::ceil(way.norm() / kStep_m)));
    for (int k = 1; k <= pieces; ++k) {
      const double f = static_cast<double>(k) / pieces;
      const double to_m = s_m + f * way.norm();
      places.push_back({path[i - 1].position() + f * way, to_m, arrivalAfter(to_m, speed_mps, params)});
    }
    s_m += way.norm();
  }
  return places;
}

/// Smallest distance between a place and an obstacle during a span of time.
double nearest(const Eigen::Vector2d& p, const TrackedObstacle& obstacle, double from_s, double to_s) {
  // The obstacle's way is a straight segment: the nearest point of it.
  const Eigen::Vector2d a = obstacle.at(from_s);
  const Eigen::Vector2d way = obstacle.at(to_s) - a;
  const double squared = way.squaredNorm();
  const double f = squared > 0.0 ? std::clamp((p - a).dot(way) / squared, 0.0, 1.0) : 0.0;
  return (p - a - f * way).norm();
}

double keepDistance(const TrackedObstacle& obstacle, double robot_radius_m, const RightOfWayParams& params) {
  const double sigma_m = std::sqrt(0.5 * obstacle.covariance.topLeftCorner<2, 2>().trace());
  return robot_radius_m + std::min(obstacle.radius_m, params.largest_radius_m) + params.keep_m +
         params.speed_sigmas * std::min(sigma_m, 0.2);
}

double yieldTo(const std::vector<PlaceInTime>& places, const TrackedObstacle& obstacle, double keep_m,
               double touching_m, const RightOfWayParams& params) {
  const auto arrival_s = [](const PlaceInTime& place) { return place.arrival_s; };
  const auto meets = [&](const PlaceInTime& place) {
    const double t = arrival_s(place);
    if (t - params.late_s > params.horizon_s) return false;
    return nearest(place.p, obstacle, std::max(0.0, t - params.late_s), t + params.early_s) < keep_m;
  };
  const auto meeting = std::find_if(places.begin(), places.end(), meets);
  const double all_m = std::numeric_limits<double>::infinity();
  if (meeting == places.end()) return all_m;
  const auto inStrip = [&](const PlaceInTime& place) {
    return nearest(place.p, obstacle, 0.0, params.horizon_s) < keep_m;
  };
  if (!inStrip(places.front())) {
    return std::find_if(places.begin(), places.end(), inStrip)->s_m;
  }
  // Already in its strip: drive on where that keeps more distance than standing.
  double driving_m = std::numeric_limits<double>::infinity();
  double standing_m = nearest(places.front().p, obstacle, 0.0, params.horizon_s);
  for (double t = 0.0; t <= params.horizon_s; t += kStep_s) {
    const auto there = std::find_if(places.begin(), places.end(),
                                    [&](const PlaceInTime& place) { return arrival_s(place) >= t; });
    const Eigen::Vector2d p = there == places.end() ? places.back().p : there->p;
    driving_m = std::min(driving_m, (p - obstacle.at(t)).norm());
  }
  return driving_m > standing_m + 0.05 && driving_m >= touching_m + params.leave_m ? all_m : 0.0;
}

}  // namespace

double lengthToYield(const Path2& path, const std::vector<TrackedObstacle>& moving, double robot_radius_m,
                     const RightOfWayParams& params, double speed_mps) {
  const std::vector<PlaceInTime> places = placesAlong(path, speed_mps, params);
  double length_m = lengthOf(path);
  if (places.empty()) return length_m;
  for (const TrackedObstacle& obstacle : moving) {
    const double keep_m = keepDistance(obstacle, robot_radius_m, params);
    const double touching_m = robot_radius_m + std::min(obstacle.radius_m, params.largest_radius_m);
    length_m = std::min(length_m, yieldTo(places, obstacle, keep_m, touching_m, params));
  }
  return length_m;
}

}  // namespace frugal_nav
