#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/planning/body_extent.hpp>

namespace frugal_nav {

/// What the velocity methods may ask of the base: to be kept within base_controller's limits.
struct SpeedParams {
  double max_v_mps = 0.35;
  double min_v_mps = 0.08;
  double max_w_radps = 1.0;
  double brake_mps2 = 0.6;
  double reaction_s = 0.25;
  double turn_gain = 2.5;
  double gentle_rad = 0.3;
  double full_speed_rad = 0.15;
  double turn_on_spot_rad = 0.9;
  double full_clearance_m = 0.35;
  double stop_short_m = 0.05;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("max_v_mps", max_v_mps, Field{"m/s", "fastest: base_controller's limits/max_v_mps", 0.01, 5.0});
    visit("min_v_mps", min_v_mps,
          Field{"m/s", "slowest that clearance makes it; the collision stop alone goes below", 0.0, 5.0});
    visit("max_w_radps", max_w_radps,
          Field{"rad/s", "fastest turn: base_controller's limits/max_w_radps", 0.05, 10.0});
    visit("brake_mps2", brake_mps2,
          Field{"m/s^2", "deceleration the stopping distance rests on; less than base_controller's", 0.05,
                20.0});
    visit("reaction_s", reaction_s,
          Field{"s", "from what is seen to the wheels: a scan's period and the motors' lag", 0.0, 2.0});
    visit("turn_gain", turn_gain, Field{"1/s", "turn rate per angle to the chosen direction", 0.1, 20.0});
    visit("gentle_rad", gentle_rad,
          Field{"rad",
                "below this angle it turns the more gently the smaller the angle and the more room there is "
                "beside the way: noise of scan and path does not make it wag; 0: never",
                0.0, M_PI});
    visit("full_speed_rad", full_speed_rad,
          Field{"rad", "up to this angle to the chosen direction it drives at full speed", 0.0, M_PI});
    visit("turn_on_spot_rad", turn_on_spot_rad,
          Field{"rad", "from this angle on it turns on the spot", 0.05, M_PI});
    visit("full_clearance_m", full_clearance_m,
          Field{"m", "obstacles beside the way farther off than this do not slow it down", 0.01, 5.0});
    visit("stop_short_m", stop_short_m, Field{"m", "air left before an obstacle it stops for", 0.0, 1.0});
  }
  std::string check() const {
    if (min_v_mps > max_v_mps) return "min_v_mps is above max_v_mps";
    return full_speed_rad < turn_on_spot_rad ? "" : "full_speed_rad must be less than turn_on_spot_rad";
  }
};

/// Turns a direction into a velocity: slower the sharper the turn, the nearer the obstacles beside the way,
/// and never faster than the robot can stop before what lies ahead. It steers exactly where the way is narrow
/// and gently where it is wide.
class SpeedChoice {
 public:
  /// Throws ConfigError on parameters out of range.
  SpeedChoice(const SpeedParams& params, const BodyExtent& body);

  /// The velocity toward a bearing in base_link, to stop after `way_m`; obstacles in base_link.
  Twist2 choose(double bearing_rad, double way_m, const std::vector<Eigen::Vector2d>& obstacles_base) const;

  /// Fastest speed from which the robot stops within a distance: v t + v^2 / 2a = d.
  double stoppable_mps(double distance_m) const;

  const SpeedParams& params() const { return params_; }

 private:
  SpeedParams params_;
  BodyExtent body_;
};

}  // namespace frugal_nav
