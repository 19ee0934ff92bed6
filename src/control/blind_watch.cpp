#include <cmath>

#include <frugal_nav/control/blind_watch.hpp>

namespace frugal_nav {
namespace {

bool isBlind(const LaserScan& scan, const Pose2& base_from_laser, double bearing_rad) {
  constexpr double kHalfCone_rad = 20.0 / 180.0 * M_PI;
  int known = 0;
  int unknown = 0;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double beam_rad = base_from_laser.yaw_rad + scan.angleOf(i);
    if (std::abs(angleBetween(bearing_rad, beam_rad)) > kHalfCone_rad) continue;
    ++(classify(scan, scan.ranges_m[i]) == Return::kUnknown ? unknown : known);
  }
  return unknown >= known;
}

}  // namespace

void BlindWatch::add(const LaserScan& scan, const Pose2& base_from_laser) {
  blind_ahead_ = isBlind(scan, base_from_laser, 0.0) ? blind_ahead_ + 1 : 0;
  blind_behind_ = isBlind(scan, base_from_laser, M_PI) ? blind_behind_ + 1 : 0;
}

}  // namespace frugal_nav
