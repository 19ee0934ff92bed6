#pragma once

#include <string>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// Gains of the drive to a point.
struct WaypointParams {
  double k_rho = 1.0;
  double k_alpha = 2.0;
  double slow_from_rad = 0.35;
  double stop_from_rad = 0.9;
  double reached_m = 0.03;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("k_rho", k_rho, Field{"1/s", "speed per distance to the point", 0.05, 10.0});
    visit("k_alpha", k_alpha, Field{"1/s", "turn rate per bearing error", 0.05, 20.0});
    visit("slow_from_rad", slow_from_rad,
          Field{"rad", "from this bearing error the robot drives slower", 0.0, M_PI});
    visit(
        "stop_from_rad", stop_from_rad,
        Field{"rad", "from this bearing error it turns on the spot: driving on would lead away", 0.01, M_PI});
    visit(
        "reached_m", reached_m,
        Field{"m", "nearer than this it stands: the bearing to a point underneath means nothing", 0.0, 1.0});
  }
  std::string check() const {
    return slow_from_rad < stop_from_rad ? "" : "slow_from_rad must be less than stop_from_rad";
  }
};

/// Drives to a point: v = k_rho rho, w = k_alpha alpha (Siegwart & Nourbakhsh, Autonomous Mobile
/// Robots, 3.6), v fading out while the bearing error alpha is large. Limits are the VelocityLimiter's task.
class WaypointController {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit WaypointController(const WaypointParams& params);

  Twist2 command(const Pose2& odom_from_base, const Eigen::Vector2d& p_odom) const;

 private:
  WaypointParams params_;
};

}  // namespace frugal_nav
