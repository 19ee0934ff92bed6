#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/planning/active_window.hpp>
#include <frugal_nav/planning/sector_ring.hpp>

namespace frugal_nav {

struct HistogramParams {
  int sectors = 72;
  double radius_m = 1.5;
  double nearness = 4.0;
  double tau_low = 0.25;
  double tau_high = 0.5;
  int wide_sectors = 16;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("sectors", sectors, Field{"", "directions around the robot; 72 are 5 degrees each", 16, 720});
    visit("radius_m", radius_m, Field{"m", "of the active window; never farther than the target", 0.3, 10.0});
    visit("nearness", nearness,
          Field{"", "magnitude of a certain cell at the robot over that at the window's border", 1.0, 100.0});
    visit("tau_low", tau_low,
          Field{"", "a sector below this becomes free; certain cells at the window's border count 1", 0.0,
                100.0});
    visit("tau_high", tau_high, Field{"", "a sector above this becomes blocked", 0.0, 100.0});
    visit("wide_sectors", wide_sectors,
          Field{"", "a wider valley is not driven through its middle but along its near side", 2, 360});
  }
  std::string check() const { return tau_low <= tau_high ? "" : "tau_low is above tau_high"; }
};

/// Where and how a histogram is taken.
struct HistogramView {
  Eigen::Vector2d p_odom;         ///< of the robot
  double heading_rad = 0.0;       ///< in odom
  double enlargement_m = 0.0;     ///< obstacles grow by this: half the body's width and the safety distance
  double turning_radius_m = 0.0;  ///< smallest circle the robot drives now; zero: it turns on the spot
  double within_m = HUGE_VAL;     ///< obstacles farther away do not count
};

/// The polar histogram of VFH+ (Ulrich and Borenstein, 1998), its sectors fixed in odom.
///
/// 1. Primary: a cell at distance d with certainty c adds c^2 (a - b d^2), a - b radius^2 = 1, to every
/// sector
///    within asin(enlargement / d) of its bearing.
/// 2. Binary: blocked above tau_high, free below tau_low, in between as it was before.
/// 3. Masked: free only where also reachable on the robot's turning circles: a cell that the circle to one
///    side, enlarged, overlaps blocks that side from its bearing outward.
class PolarHistogram {
 public:
  /// `previous` keeps the binary states in between; nullptr takes them for blocked.
  PolarHistogram(const HistogramParams& params, const HistogramView& view,
                 const std::vector<WindowPoint>& points, const SectorRing* previous);

  const SectorRing& binary() const { return binary_; }
  const SectorRing& masked() const { return masked_; }
  const std::vector<double>& density() const { return density_; }

  /// Directions to drive in, in odom: the middle of narrow valleys, the two sides of wide ones, and the
  /// target direction where it lies within those. Empty when all is blocked.
  std::vector<double> candidates(double target_rad) const;

 private:
  void measure(const HistogramView& view, const std::vector<WindowPoint>& points);
  void mask(const HistogramView& view, const std::vector<WindowPoint>& points);
  void addValley(int first, int count, double target_rad, std::vector<double>& directions) const;

  HistogramParams params_;
  std::vector<double> density_;
  SectorRing binary_;
  SectorRing masked_;
};

}  // namespace frugal_nav
