#include <algorithm>
#include <cmath>

#include <frugal_nav/planning/sector_ring.hpp>

namespace frugal_nav {
namespace {

constexpr double kRounding_rad = 1e-4;  // a centre on the limit is within it, also when 25 degrees are 0.4363

int wrapSector(int sector, int size) {
  const int rest = sector % size;
  return rest < 0 ? rest + size : rest;
}

}  // namespace

int SectorRing::sectorOf(double bearing_rad) const {
  return wrapSector(static_cast<int>(std::floor(wrapAngle(bearing_rad) / width_rad() + 0.5)), size());
}

void SectorRing::blockAround(double bearing_rad, double half_width_rad) {
  block(sectorOf(bearing_rad));
  const int first = static_cast<int>(std::ceil((bearing_rad - half_width_rad - kRounding_rad) / width_rad()));
  const int last = static_cast<int>(std::floor((bearing_rad + half_width_rad + kRounding_rad) / width_rad()));
  for (int i = first; i <= std::min(last, first + size() - 1); ++i) block(wrapSector(i, size()));
}

std::vector<bool> observedSectors(const SectorRing& ring, const LaserScan& scan,
                                  const Pose2& base_from_laser) {
  const auto size = static_cast<std::size_t>(ring.size());
  std::vector<int> known(size, 0);
  std::vector<int> beams(size, 0);
  // Where beams are farther apart than sectors are wide, each speaks for the directions half way to the next.
  const int reach = static_cast<int>(std::abs(scan.angle_increment_rad) / ring.width_rad() / 2.0);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const bool is_known = classify(scan, scan.ranges_m[i]) != Return::kUnknown;
    const int middle = ring.sectorOf(base_from_laser.yaw_rad + scan.angleOf(i));
    for (int offset = -reach; offset <= reach; ++offset) {
      const auto sector = static_cast<std::size_t>(wrapSector(middle + offset, ring.size()));
      ++beams[sector];
      if (is_known) ++known[sector];
    }
  }
  std::vector<bool> observed(size);
  for (std::size_t i = 0; i < size; ++i) observed[i] = beams[i] > 0 && 2 * known[i] >= beams[i];
  return observed;
}

std::vector<double> sectorClearances(const SectorRing& ring, const std::vector<bool>& observed,
                                     const std::vector<Eigen::Vector2d>& obstacles_base, double longest_m) {
  std::vector<double> clearances(static_cast<std::size_t>(ring.size()), longest_m);
  for (std::size_t i = 0; i < clearances.size(); ++i) {
    if (!observed[i]) clearances[i] = 0.0;
  }
  for (const Eigen::Vector2d& p : obstacles_base) {
    double& clearance = clearances[static_cast<std::size_t>(ring.sectorOf(std::atan2(p.y(), p.x())))];
    clearance = std::min(clearance, p.norm());
  }
  return clearances;
}

double clearestBearing(const SectorRing& ring, const std::vector<double>& clearances_m, double half_width_rad,
                       double wanted_rad) {
  const int reach = static_cast<int>(std::lround(half_width_rad / ring.width_rad()));
  double best_clearance = -1.0;
  double best_detour = 0.0;
  double best = 0.0;
  for (int sector = 0; sector < ring.size(); ++sector) {
    double clearance = clearances_m[static_cast<std::size_t>(sector)];
    for (int offset = -reach; offset <= reach; ++offset) {
      const auto beside = static_cast<std::size_t>(wrapSector(sector + offset, ring.size()));
      clearance = std::min(clearance, clearances_m[beside]);
    }
    const double detour = std::abs(angleBetween(wanted_rad, ring.bearingOf(sector)));
    if (clearance < best_clearance || (clearance == best_clearance && detour >= best_detour)) continue;
    best_clearance = clearance;
    best_detour = detour;
    best = ring.bearingOf(sector);
  }
  return best;
}

}  // namespace frugal_nav
