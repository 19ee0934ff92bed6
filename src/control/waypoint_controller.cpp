#include <algorithm>

#include <frugal_nav/control/waypoint_controller.hpp>

namespace frugal_nav {

WaypointController::WaypointController(const WaypointParams& params) : params_(params) {
  validate(params, "waypoint controller");
}

Twist2 WaypointController::command(const Pose2& odom_from_base, const Eigen::Vector2d& p_odom) const {
  const double rho = (p_odom - odom_from_base.position()).norm();
  if (rho <= params_.reached_m) return {};
  const double alpha = bearingTo(odom_from_base, p_odom);
  const double fade = std::clamp(
      (params_.stop_from_rad - std::abs(alpha)) / (params_.stop_from_rad - params_.slow_from_rad), 0.0, 1.0);
  return {params_.k_rho * rho * fade, params_.k_alpha * alpha};
}

}  // namespace frugal_nav
