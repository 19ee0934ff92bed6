#pragma once

#include <deque>
#include <optional>

#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/head_range.hpp>

namespace frugal_nav {

/// When the feet tell how large a head is.
struct HeadCalibrationParams {
  bool enabled = true;
  double max_range_m = 4.0;
  double half_width_m = 0.2;
  double body_depth_m = 0.15;
  double body_sigma_m = 0.08;
  double max_ratio = 1.3;
  int min_samples = 5;
  int max_samples = 25;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("enabled", enabled,
          Field{"",
                "whether the surfaces that depth/scan shows correct the head's size, person by person, and "
                "the place of one whose head is above the image"});
    visit("max_range_m", max_range_m,
          Field{"m", "farther surfaces are not used: where floor ends is known to a pixel, 0.12 m at 4 m",
                0.5, 20.0});
    visit("half_width_m", half_width_m,
          Field{"m", "a surface this far beside the head's bearing is still the person's", 0.05, 1.0});
    visit("body_depth_m", body_depth_m,
          Field{"m", "the middle of a person lies this far behind its nearest surface", 0.0, 0.5});
    visit("body_sigma_m", body_sigma_m,
          Field{"m", "standard deviation of that: legs stand apart", 0.01, 1.0});
    visit("max_ratio", max_ratio,
          Field{"", "a surface nearer or farther by more than this is another thing's: heads differ by less",
                1.01, 2.0});
    visit("min_samples", min_samples, Field{"", "images after which their median counts", 1, 1000});
    visit("max_samples", max_samples, Field{"", "images whose median counts, the last ones", 1, 1000});
  }
  std::string check() const {
    return min_samples <= max_samples ? "" : "min_samples must not exceed max_samples";
  }
};

/// How far the middle of a person is who is thought to be at a bearing and range, by the nearest surfaces of
/// the same view, in base_link [m]; nothing when none is there.
std::optional<double> bodyRange(double bearing_rad, double range_m, const LaserScan& surfaces,
                                const HeadCalibrationParams& params);

/// Whether what stands at a bearing and range has air to both sides: a wall has not, nor what the view cuts.
bool standsFree(double bearing_rad, double range_m, const LaserScan& surfaces,
                const HeadCalibrationParams& params);

/// How large one person's head is over what is assumed, from where the same person's feet stand. The error of
/// an assumed size is the same in all images: averaging does not remove it, this does.
class HeadCalibration {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit HeadCalibration(const HeadCalibrationParams& params);

  /// A head located with the assumed size, and the nearest surfaces of the same image, in base_link.
  void add(const HeadSighting& head, const LaserScan& surfaces);
  /// True head size over the assumed one; 1 until enough is known.
  double factor() const;
  bool isKnown() const;
  const HeadCalibrationParams& params() const { return params_; }
  void reset() { ratios_.clear(); }

 private:
  HeadCalibrationParams params_;
  std::deque<double> ratios_;
};

}  // namespace frugal_nav
