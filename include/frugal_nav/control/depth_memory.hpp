#pragma once

#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// How long the collision stop keeps in mind what the camera has seen.
struct DepthMemoryParams {
  double memory_s = 5.0;
  double range_m = 1.5;
  double below_view_m = 0.5;
  double cell_m = 0.03;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit(
        "memory_s", memory_s,
        Field{"s",
              "what has left the camera's view is kept this long: it takes the robot 4 s to pass at 0.15 m/s "
              "what leaves a view of 62 degrees beside it",
              0.0, 60.0});
    visit(
        "range_m", range_m,
        Field{"m", "farther points of depth/scan are not kept: the stopping way is much shorter", 0.1, 20.0});
    visit("below_view_m", below_view_m,
          Field{"m",
                "nearer than this a later image does not take back what was seen: low things are below its "
                "view",
                0.0, 5.0});
    visit("cell_m", cell_m, Field{"m", "one point is kept for each square of this side", 0.005, 0.5});
  }
};

/// The points of the last depth/scan messages, in odom. The camera looks ahead only: what the robot passes or
/// turns away from is out of its view, but still there.
class DepthMemory {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit DepthMemory(const DepthMemoryParams& params) { setParams(params); }

  /// Other parameters from the next scan on. Throws ConfigError on parameters out of range.
  void setParams(const DepthMemoryParams& params);

  /// Keeps the hits of a scan in base_link, and forgets what it sees through and what is too old.
  void add(const LaserScan& scan, const Pose2& odom_from_base);
  void clear() { points_.clear(); }

  /// All points at an instant, in the base's frame then [m].
  std::vector<Eigen::Vector2d> pointsAt(Stamp now, const Pose2& odom_from_base) const;

 private:
  struct Point {
    Eigen::Vector2d p_odom;
    Stamp stamp{};
  };
  bool isSeenThrough(const Eigen::Vector2d& p_base, const LaserScan& scan) const;

  DepthMemoryParams params_;
  std::vector<Point> points_;
};

}  // namespace frugal_nav
