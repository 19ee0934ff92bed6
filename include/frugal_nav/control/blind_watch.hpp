#pragma once

#include <frugal_nav/common/laser_scan.hpp>

namespace frugal_nav {

/// Tells whether the scanner has seen anything, obstacle or free space, in the direction of motion. A
/// direction is blind when at least half of the beams within 20 degrees of it were unknown (NaN), or there
/// were none, in the last three scans: single drop-outs are common, a covered or missing field of view stays.
class BlindWatch {
 public:
  void add(const LaserScan& scan, const Pose2& base_from_laser);
  void reset() { *this = {}; }

  bool isBlindAhead() const { return blind_ahead_ >= kScans; }
  bool isBlindBehind() const { return blind_behind_ >= kScans; }

 private:
  static constexpr int kScans = 3;
  int blind_ahead_ = 0;
  int blind_behind_ = 0;
};

}  // namespace frugal_nav
