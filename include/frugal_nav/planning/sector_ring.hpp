#pragma once

#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>

namespace frugal_nav {

/// The directions around the robot in equal sectors; sector i is centred on i times its width, from straight
/// ahead counter-clockwise, in base_link.
class SectorRing {
 public:
  explicit SectorRing(int sectors) : free_(static_cast<std::size_t>(sectors), true) {}

  int size() const { return static_cast<int>(free_.size()); }
  double width_rad() const { return 2.0 * M_PI / size(); }
  double bearingOf(int sector) const { return wrapAngle(sector * width_rad()); }
  int sectorOf(double bearing_rad) const;
  bool isFree(int sector) const { return free_[static_cast<std::size_t>(sector)]; }

  /// Blocks one sector.
  void block(int sector) { free_[static_cast<std::size_t>(sector)] = false; }
  /// Blocks every sector whose centre lies within `half_width_rad` of a bearing, and the one that holds it.
  void blockAround(double bearing_rad, double half_width_rad);

 private:
  std::vector<bool> free_;
};

/// Which sectors a scan says anything about: those that hold beams, at least half of them known (NaN is
/// unknown, REP-117).
std::vector<bool> observedSectors(const SectorRing& ring, const LaserScan& scan,
                                  const Pose2& base_from_laser);

/// Distance from base_link to the nearest obstacle of each sector, at most `longest_m`; zero where the scan
/// says nothing [m].
std::vector<double> sectorClearances(const SectorRing& ring, const std::vector<bool>& observed,
                                     const std::vector<Eigen::Vector2d>& obstacles_base, double longest_m);

/// Bearing of the direction whose neighbourhood (`half_width_rad` to each side) is clear the farthest; of
/// equal ones the nearest to `wanted_rad`.
double clearestBearing(const SectorRing& ring, const std::vector<double>& clearances_m, double half_width_rad,
                       double wanted_rad);

}  // namespace frugal_nav
