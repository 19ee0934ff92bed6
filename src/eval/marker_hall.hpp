#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/perception/marker_map.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::eval {

/// A hall whose walls and pillars carry markers, with a tour.
struct MarkerHall {
  sim::Scene scene;
  MarkerMap map;                           ///< its frame is the world's
  std::string light;                       ///< "daylight", "dim" or "tube"
  Pose2 start;                             ///< a marker is near ahead
  std::vector<Eigen::Vector2d> waypoints;  ///< in the map [m]
  double tour_m = 0.0;                     ///< shortest way of the disc that must fit
};

/// Draws a hall from a seed: painted, furnished and lit at random, two to four pillars, markers of 0.20 m
/// wherever there is room for them. A disc of `disc_radius_m` fits along the tour. `textures` are those of
/// the package's folder `worlds`.
MarkerHall makeMarkerHall(std::uint64_t seed, double disc_radius_m, int waypoints,
                          const std::vector<sim::Texture>& textures);

/// Hangs a marker, printed on a board, into a scene; `name` is the model's.
void hangMarker(const MappedMarker& marker, const std::string& dictionary, const std::string& name,
                sim::Scene& scene);

/// Whether a camera sees a marker whole, from no more than `max_range_m` and 60 degrees aside, with nothing
/// before it.
bool isInView(const MappedMarker& marker, const Pinhole& camera, const Eigen::Isometry3d& map_from_optical,
              double max_range_m, const sim::RayTracer& tracer);

}  // namespace frugal_nav::eval
