#pragma once

#include <optional>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// How long the collision stop keeps in mind what scans have shown. The defaults are those of a camera's.
struct ScanMemoryParams {
  double memory_s = 5.0;
  double range_m = 1.5;
  double below_view_m = 0.5;
  double cell_m = 0.03;
  double tolerance_m = 0.0;

  /// Those of a laser, which sees all around but nothing nearer than its range_min.
  static ScanMemoryParams ofLaser() { return {3.0, 0.5, 0.0, 0.005, 0.02}; }

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("memory_s", memory_s,
          Field{"s",
                "what no beam measures any more is kept this long, or while beams say that something is too "
                "near: the robot passes at 0.15 m/s in 4 s what leaves a camera's view of 62 degrees beside "
                "it, in 3 s what comes too near beside the laser",
                0.0, 60.0});
    visit("range_m", range_m, Field{"m", "farther points are not kept: stopping takes less way", 0.1, 20.0});
    visit(
        "below_view_m", below_view_m,
        Field{"m",
              "nearer to the sensor than this a later scan does not take back what two scans have seen: low "
              "things are below a camera's view",
              0.0, 5.0});
    visit("cell_m", cell_m,
          Field{"m",
                "one point is kept for each square of this side, so that a corner is known to within its "
                "diagonal: less than the air that the collision stop keeps",
                0.005, 0.5});
    visit(
        "tolerance_m", tolerance_m,
        Field{"m",
              "how far off a kept place may be: beams within this on either side must measure something, the "
              "middle one at most this much before it, to take it back; and what seems this deep within "
              "the footprint is a part of the robot",
              0.0, 0.2});
  }
};

/// The points of the last scans, in odom: what the robot passes or turns away from, and what comes nearer
/// than can be measured, is still there.
class ScanMemory {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit ScanMemory(const ScanMemoryParams& params) { setParams(params); }

  /// Other parameters from the next scan on. Throws ConfigError on parameters out of range.
  void setParams(const ScanMemoryParams& params);

  /// Keeps the hits of a scan, and forgets what it measures anew or sees through and what is too old.
  void add(const LaserScan& scan, const Pose2& base_from_sensor, const Pose2& odom_from_base);
  void clear() { points_.clear(); }
  /// Whether a beam that says "too near" sees what is kept, of before it came too near.
  bool knows(const LaserScan& scan, std::size_t beam, const Pose2& odom_from_sensor) const;

  /// All points at an instant, in the base's frame then [m].
  std::vector<Eigen::Vector2d> pointsAt(Stamp now, const Pose2& odom_from_base) const;

 private:
  struct Point {
    Eigen::Vector2d p_odom;
    Stamp stamp{};
    bool confirmed = false;  ///< seen about there in another scan too
  };
  enum class View { kThrough, kHidden, kTooClose };
  View viewOf(const Eigen::Vector2d& p_sensor, bool confirmed, const LaserScan& scan) const;
  bool isConfirmed(const Eigen::Vector2d& p_odom) const;

  ScanMemoryParams params_;
  std::vector<Point> points_;
};

}  // namespace frugal_nav
