#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>

namespace frugal_nav::sim {

/// A planar scanning laser; the defaults are an RPLIDAR A1's, from its data sheet.
struct LidarParams {
  int beams = 360;
  double field_of_view_rad = 2.0 * M_PI;
  double rate_hz = 7.0;
  double angle_min_rad = -M_PI;
  double range_min_m = 0.15;
  double range_max_m = 12.0;
  double sigma_ratio = 0.01;
  double sigma_min_m = 0.001;
  double dropout_probability = 0.005;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("beams", beams, Field{"", "beams of one scan, spread evenly over the field of view", 8, 8192});
    visit("field_of_view_rad", field_of_view_rad,
          Field{"rad", "from the first beam to the last; a full turn leaves a gap between them", 0.1,
                2.0 * M_PI});
    visit("rate_hz", rate_hz, Field{"Hz", "scans a second: the A1 turns at 5.5 to 10 Hz", 1.0, 100.0});
    visit("angle_min_rad", angle_min_rad,
          Field{"rad", "bearing of the first beam; the others follow counter-clockwise", -M_PI, M_PI});
    visit("range_min_m", range_min_m, Field{"m", "nearest range measured; nearer reads -inf", 0.0, 10.0});
    visit("range_max_m", range_max_m, Field{"m", "farthest range measured; farther reads +inf", 0.1, 100.0});
    visit("sigma_ratio", sigma_ratio,
          Field{"", "standard deviation over range: the data sheet's resolution is 1 % of the range", 0.0,
                0.2});
    visit(
        "sigma_min_m", sigma_min_m,
        Field{"m", "smallest standard deviation: near by, quantisation (0.5 mm) is what remains", 0.0, 0.1});
    visit("dropout_probability", dropout_probability,
          Field{"", "share of beams that return nothing and read NaN", 0.0, 1.0});
  }
  std::string check() const {
    return range_min_m < range_max_m ? "" : "range_min_m must be less than range_max_m";
  }
};

/// A laser scanner in a ray-traced scene. All beams of a scan are taken at one instant.
class Lidar {
 public:
  /// Throws ConfigError on parameters out of range.
  Lidar(const LidarParams& params, std::uint64_t seed);

  /// One turn from a pose of the laser's frame (x ahead, z up). Ranges follow REP-117.
  LaserScan scan(const RayTracer& tracer, const Eigen::Isometry3d& world_from_laser, Stamp stamp);

  const LidarParams& params() const { return params_; }

 private:
  float measure(double range_m);

  LidarParams params_;
  double increment_rad_;
  Random random_;
  std::vector<Eigen::Vector2f> directions_;  // in the laser's frame, one a beam
};

}  // namespace frugal_nav::sim
