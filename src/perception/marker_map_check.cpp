#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <frugal_nav/perception/marker_map_check.hpp>
#include <frugal_nav/perception/marker_sheet.hpp>

namespace frugal_nav {
namespace {

constexpr double kSamePlane_m = 0.03;       // markers nearer than that cover each other
constexpr double kFarthestApart_m = 200.0;  // farther than indoor places reach

using Square = std::array<Eigen::Vector2d, 4>;

template <class... Values>
std::string format(const char* text, Values... values) {
  char line[200];
  std::snprintf(line, sizeof line, text, values...);
  return line;
}

/// Whether an edge of `a` has all of `b` on its outside (separating axis theorem; corners are clockwise).
bool parts(const Square& a, const Square& b) {
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d edge = a[(i + 1) % 4] - a[i];
    const auto isOutside = [&](const Eigen::Vector2d& p) {
      return edge.x() * (p - a[i]).y() - edge.y() * (p - a[i]).x() >= 0.0;
    };
    if (std::all_of(b.begin(), b.end(), isOutside)) return true;
  }
  return false;
}

Square withBorder(const MappedMarker& marker, const Eigen::Isometry3d& plane_from_marker) {
  Square square;
  const auto corners = markerCorners(marker.size_m * (1.0 + 2.0 * kMarkerBorderShare));
  for (std::size_t i = 0; i < 4; ++i) square[i] = (plane_from_marker * corners[i]).head<2>();
  return square;
}

/// Whether two sheets lie on one another. Back to back they do not disturb.
bool overlap(const MappedMarker& a, const MappedMarker& b) {
  const Eigen::Isometry3d a_from_b = a.map_from_marker.inverse() * b.map_from_marker;
  if (a_from_b.linear()(2, 2) < std::cos(M_PI / 6.0)) return false;
  const auto corners = b.corners();
  const bool in_front = std::all_of(corners.begin(), corners.end(), [&](const Eigen::Vector3d& p) {
    return (a_from_b * p).z() > kSamePlane_m;
  });
  const bool behind = std::all_of(corners.begin(), corners.end(), [&](const Eigen::Vector3d& p) {
    return (a_from_b * p).z() < -kSamePlane_m;
  });
  if (in_front || behind) return false;
  const Square square_a = withBorder(a, Eigen::Isometry3d::Identity());
  const Square square_b = withBorder(b, a_from_b);
  return !parts(square_a, square_b) && !parts(square_b, square_a);
}

void checkReach(const MappedMarker& marker, const MarkerMapLimits& limits, std::vector<std::string>& found) {
  double lowest_m = marker.map_from_marker.translation().z();
  for (const Eigen::Vector3d& corner : marker.corners())
    lowest_m = std::min(lowest_m, (marker.map_from_marker * corner).z());
  const double height_m = marker.map_from_marker.translation().z();
  if (lowest_m < limits.min_height_m)
    found.push_back(format("marker %d: its lower edge is at %.2f m, below %.2f m", marker.id, lowest_m,
                           limits.min_height_m));
  if (height_m > limits.max_height_m)
    found.push_back(
        format("marker %d: its centre is at %.2f m, above %.2f m: is it in view, is it in metres?", marker.id,
               height_m, limits.max_height_m));
  const double normal_z = std::clamp(marker.map_from_marker.linear()(2, 2), -1.0, 1.0);
  const double tilt_deg = std::abs(std::asin(normal_z)) * 180.0 / M_PI;
  if (tilt_deg > limits.max_tilt_deg)
    found.push_back(
        format("marker %d: its face looks %.0f deg %s, more than %.0f deg: z points out of the face",
               marker.id, tilt_deg, normal_z > 0.0 ? "up" : "down", limits.max_tilt_deg));
}

void checkPair(const MappedMarker& a, const MappedMarker& b, std::vector<std::string>& found) {
  if (overlap(a, b))
    found.push_back(format("markers %d and %d overlap, or their white borders do", a.id, b.id));
  const double apart_m = (a.map_from_marker.translation() - b.map_from_marker.translation()).norm();
  if (apart_m > kFarthestApart_m)
    found.push_back(
        format("markers %d and %d are %.0f m apart: are their positions in metres?", a.id, b.id, apart_m));
}

}  // namespace

std::vector<std::string> suspicionsAbout(const MarkerMap& map, const MarkerMapLimits& limits) {
  std::vector<std::string> found;
  for (auto a = map.markers.begin(); a != map.markers.end(); ++a) {
    checkReach(a->second, limits, found);
    for (auto b = std::next(a); b != map.markers.end(); ++b) checkPair(a->second, b->second, found);
  }
  for (const int id : map.whitelist) {
    if (map.markers.count(id) == 0)
      found.push_back(format("whitelist: marker %d has no place in the map and is of no use", id));
  }
  return found;
}

}  // namespace frugal_nav
