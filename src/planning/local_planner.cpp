#include <frugal_nav/planning/local_planner.hpp>
#include <frugal_nav/planning/sector_ring.hpp>

namespace frugal_nav {
namespace {

constexpr double kLongestClearance_m = 4.0;  // clear is clear: a far wall is no better than a farther one
constexpr int kSectors = 72;
constexpr double kHalfWidth_rad = 25.0 / 180.0 * M_PI;

}  // namespace

double clearBearing(const LocalPlannerInput& input) {
  const SectorRing ring(kSectors);
  const std::vector<bool> observed = observedSectors(ring, input.scan, input.base_from_laser);
  return clearestBearing(ring, sectorClearances(ring, observed, input.obstacles_base, kLongestClearance_m),
                         kHalfWidth_rad, bearingTo(input.odometry.odom_from_base, input.target_odom));
}

}  // namespace frugal_nav
