#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/planning/body_extent.hpp>

namespace frugal_nav::planning_test {

/// frugal_bot's: 0.25 m wide, its tail 0.16 m behind base_link.
constexpr BodyExtent kBody{0.125, 0.203};

struct Segment {
  Eigen::Vector2d a;
  Eigen::Vector2d b;
};

/// Walls on a plane, and the scans a laser in base_link would give of them: no noise, 360 beams, 0.15 .. 12
/// m.
class FlatWorld {
 public:
  FlatWorld& wall(double x1, double y1, double x2, double y2) {
    walls_.push_back({{x1, y1}, {x2, y2}});
    return *this;
  }
  FlatWorld& box(double x1, double y1, double x2, double y2) {
    return wall(x1, y1, x2, y1).wall(x2, y1, x2, y2).wall(x2, y2, x1, y2).wall(x1, y2, x1, y1);
  }

  LaserScan scan(const Pose2& world_from_laser, double stamp_s = 0.0) const {
    LaserScan scan;
    scan.stamp = stampFromSeconds(stamp_s);
    scan.angle_min_rad = -M_PI;
    scan.angle_increment_rad = 2.0 * M_PI / 360.0;
    scan.range_min_m = 0.15;
    scan.range_max_m = 12.0;
    for (std::size_t i = 0; i < 360; ++i) {
      const double range = rangeOf(world_from_laser, scan.angleOf(i));
      const bool seen = range >= scan.range_min_m && range <= scan.range_max_m;
      const float none = range < scan.range_min_m ? -std::numeric_limits<float>::infinity()
                                                  : std::numeric_limits<float>::infinity();
      scan.ranges_m.push_back(seen ? static_cast<float>(range) : none);
    }
    return scan;
  }

  /// Distance from a place to the nearest wall [m].
  double clearance(const Eigen::Vector2d& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Segment& s : walls_) {
      const Eigen::Vector2d line = s.b - s.a;
      const double f = std::clamp((p - s.a).dot(line) / line.squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (p - s.a - f * line).norm());
    }
    return nearest;
  }

 private:
  double rangeOf(const Pose2& from, double angle_rad) const {
    const Eigen::Vector2d d(std::cos(from.yaw_rad + angle_rad), std::sin(from.yaw_rad + angle_rad));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Segment& s : walls_) {
      const Eigen::Vector2d line = s.b - s.a;
      const double determinant = d.y() * line.x() - d.x() * line.y();
      if (std::abs(determinant) < 1e-12) continue;
      const Eigen::Vector2d to = s.a - from.position();
      const double range = (to.y() * line.x() - to.x() * line.y()) / determinant;
      const double along = (d.x() * to.y() - d.y() * to.x()) / determinant;
      if (range >= 0.0 && along >= 0.0 && along <= 1.0) nearest = std::min(nearest, range);
    }
    return nearest;
  }

  std::vector<Segment> walls_;
};

}  // namespace frugal_nav::planning_test
