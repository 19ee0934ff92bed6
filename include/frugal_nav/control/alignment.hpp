#pragma once

#include <optional>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// How the robot turns to face its goal.
struct AlignmentParams {
  double tolerance_share = 0.03;
  double max_turn_radps = 0.6;
  double min_turn_radps = 0.15;
  double turn_per_share_radps = 1.5;
  double lost_after_s = 1.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("tolerance_share", tolerance_share,
          Field{"", "error that counts as aligned, as a share of the image's width", 0.001, 0.5});
    visit("max_turn_radps", max_turn_radps,
          Field{"rad/s", "fastest turn: the box moves a few per cent of the width a frame", 0.01, 5.0});
    visit("min_turn_radps", min_turn_radps,
          Field{"rad/s", "slowest turn: what the wheels still make of it", 0.0, 5.0});
    visit(
        "turn_per_share_radps", turn_per_share_radps,
        Field{"rad/s", "turn by the error as a share of the width: slower near the end, so that it stops in",
              0.0, 100.0});
    visit("lost_after_s", lost_after_s,
          Field{"s", "without the target that long, the alignment fails", 0.0, 60.0});
  }
  std::string check() const {
    return min_turn_radps <= max_turn_radps ? "" : "min_turn_radps must not exceed max_turn_radps";
  }
};

/// What to do now to face the target.
struct AlignmentStep {
  enum class Status {
    kTurningLeft,
    kTurningRight,
    kWaiting,  ///< the target is not seen in this frame: standing
    kDone,     ///< the target is in the middle
    kLost      ///< the target is gone: standing
  };
  Status status = Status::kWaiting;
  double error_px = 0.0;  ///< E = image centre - box centre; NaN without a box
  double w_radps = 0.0;   ///< left positive
};

/// Visual servoing (paper 000, stage 2): turns while |E| > eps, left for E > eps, right for E < -eps; stands
/// when it is done and whenever the target is not seen.
class Alignment {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit Alignment(const AlignmentParams& params);

  /// One frame: the column of the target's centre from the image's left edge, or nullopt when it is not seen.
  /// A stamp before the last one starts anew.
  AlignmentStep update(Stamp stamp, int image_width_px, std::optional<double> target_column_px);
  /// The same for a target whose bearing is known, left positive, in a camera that sees `view_rad` in all; E
  /// is given as if the image were a pixel wide.
  AlignmentStep updateBearing(Stamp stamp, double view_rad, double bearing_rad);
  /// Starts anew.
  void reset();

 private:
  AlignmentParams params_;
  std::optional<Stamp> last_stamp_;
  Stamp last_seen_{};
};

}  // namespace frugal_nav
