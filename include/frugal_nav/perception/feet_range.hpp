#pragma once

#include <optional>

#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// When surfaces tell where a person stands.
struct FeetParams {
  bool enabled = true;
  double max_range_m = 4.0;
  double half_width_m = 0.2;
  double body_depth_m = 0.15;
  double body_sigma_m = 0.08;
  double range_sigma_share = 0.05;
  double max_ratio = 1.3;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("enabled", enabled,
          Field{"", "whether the surfaces that depth/scan shows tell where the goal's feet stand"});
    visit("max_range_m", max_range_m,
          Field{"m", "farther surfaces are not used: where floor ends is known to a pixel, 0.12 m at 4 m",
                0.5, 20.0});
    visit("half_width_m", half_width_m,
          Field{"m", "a surface this far beside the person's bearing is still the person's", 0.05, 1.0});
    visit("body_depth_m", body_depth_m,
          Field{"m", "the middle of a person lies this far behind its nearest surface", 0.0, 0.5});
    visit("body_sigma_m", body_sigma_m,
          Field{"m", "standard deviation of that: legs stand apart", 0.01, 1.0});
    visit("range_sigma_share", range_sigma_share,
          Field{"", "more of it, as a share of the range: shoes are as dark as the floor beside them", 0.0,
                0.5});
    visit("max_ratio", max_ratio,
          Field{"", "a surface nearer or farther than thought by more than this is another thing's", 1.01,
                2.0});
  }
};

/// How far the middle of a person is who is thought to be at a bearing and range, by the nearest surfaces of
/// the same view, in base_link [m]; nothing when none is there.
std::optional<double> bodyRange(double bearing_rad, double range_m, const LaserScan& surfaces,
                                const FeetParams& params);

/// Whether what stands at a bearing and range has air to both sides: a wall has not, nor what the view cuts.
bool standsFree(double bearing_rad, double range_m, const LaserScan& surfaces, const FeetParams& params);

}  // namespace frugal_nav
