#include <algorithm>

#include <frugal_nav/planning/speed_choice.hpp>

namespace frugal_nav {

SpeedChoice::SpeedChoice(const SpeedParams& params, const BodyExtent& body) : params_(params), body_(body) {
  validate(params, "speed");
}

double SpeedChoice::stoppable_mps(double distance_m) const {
  const double a = params_.brake_mps2;
  const double t = params_.reaction_s;
  return a * (std::sqrt(t * t + 2.0 * std::max(distance_m, 0.0) / a) - t);
}

Twist2 SpeedChoice::choose(double bearing_rad, double way_m,
                           const std::vector<Eigen::Vector2d>& obstacles_base) const {
  // In the frame of the direction: what lies in the strip of the body ends the way, what lies beside narrows
  // it.
  const double c = std::cos(bearing_rad);
  const double s = std::sin(bearing_rad);
  const double front_m = body_.front_m();
  const double horizon_m =
      params_.max_v_mps * (params_.reaction_s + params_.max_v_mps / (2.0 * params_.brake_mps2));
  const double reach_m = horizon_m + front_m + params_.stop_short_m;
  double free_m = HUGE_VAL;
  double beside_m = params_.full_clearance_m;
  for (const Eigen::Vector2d& p : obstacles_base) {
    const double along = c * p.x() + s * p.y();
    const double aside = std::abs(c * p.y() - s * p.x()) - body_.half_width_m;
    if (along < 0.0 || along > reach_m) continue;
    if (aside <= 0.0) {
      free_m = std::min(free_m, along);
    } else {
      beside_m = std::min(beside_m, aside + 0.5 * std::max(along - front_m, 0.0));
    }
  }
  const double turn = std::abs(bearing_rad);
  const double straightness = std::clamp(
      (params_.turn_on_spot_rad - turn) / (params_.turn_on_spot_rad - params_.full_speed_rad), 0.0, 1.0);
  const double by_clearance =
      params_.min_v_mps + (params_.max_v_mps - params_.min_v_mps) * beside_m / params_.full_clearance_m;
  const double by_stopping = stoppable_mps(free_m - front_m - params_.stop_short_m);
  const double v = std::min({params_.max_v_mps * straightness, by_clearance,
                             std::max(by_stopping, straightness > 0.0 ? params_.min_v_mps : 0.0),
                             std::max(stoppable_mps(way_m), params_.min_v_mps)});
  const double room = beside_m / params_.full_clearance_m;
  const double gentleness = turn < params_.gentle_rad ? room * (1.0 - turn / params_.gentle_rad) : 0.0;
  return {v, std::clamp((1.0 - gentleness) * params_.turn_gain * bearing_rad, -params_.max_w_radps,
                        params_.max_w_radps)};
}

}  // namespace frugal_nav
