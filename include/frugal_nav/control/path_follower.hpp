#pragma once

#include <optional>
#include <string>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/control/pid.hpp>

namespace frugal_nav {

/// How a path is followed.
struct PathFollowerParams {
  double cruise_mps = 0.35;
  double look_ahead_m = 0.25;
  double slow_from_rad = 0.35;
  double stop_from_rad = 0.9;
  double k_end = 1.0;
  double reached_m = 0.03;
  double k_turn = 2.0;
  double max_turn_radps = 1.5;
  PidParams lateral{5.0, 0.0, 0.3, 0.3};

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("cruise_mps", cruise_mps, Field{"m/s", "speed along a straight path", 0.01, 5.0});
    visit("look_ahead_m", look_ahead_m,
          Field{"m",
                "the error is taken this far ahead of the robot: its heading counts, and it cuts no corner "
                "by more",
                0.01, 5.0});
    visit("slow_from_rad", slow_from_rad,
          Field{"rad", "from this angle to the path the robot drives slower", 0.0, M_PI});
    visit("stop_from_rad", stop_from_rad,
          Field{"rad", "from this angle to the path it turns on the spot", 0.01, M_PI});
    visit("k_turn", k_turn, Field{"1/s", "turn rate per angle to the path, on the spot", 0.05, 20.0});
    visit("k_end", k_end, Field{"1/s", "speed per distance left to the path's end", 0.05, 10.0});
    visit("reached_m", reached_m, Field{"m", "nearer to the path's end than this it stands", 0.0, 1.0});
    visit("max_turn_radps", max_turn_radps, Field{"rad/s", "most the controller turns", 0.05, 10.0});
    visit("lateral", lateral);
  }
  std::string check() const {
    return slow_from_rad < stop_from_rad ? "" : "slow_from_rad must be less than stop_from_rad";
  }
};

/// Follows a path: PID on the cross-track error of the point `look_ahead_m` ahead of the robot, left
/// positive.
class PathFollower {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit PathFollower(const PathFollowerParams& params);

  /// Velocity at a pose along a path in the same frame; zero at the end of the path and on an empty one.
  Twist2 command(const Path2& path, const Pose2& odom_from_base, Stamp now);
  /// Forgets the PID's past: after a stop or a change of goal.
  void reset();

 private:
  PathFollowerParams params_;
  Pid pid_;
  std::optional<Stamp> last_;
};

/// The place on a path nearest to a point.
struct PathPlace {
  double lateral_m = 0.0;    ///< of the point, left of the path positive
  double remaining_m = 0.0;  ///< from that place to the path's end, along it
  double heading_rad = 0.0;  ///< of the path there
};

/// Projects a point on a path of at least two poses at different positions; nullopt otherwise.
std::optional<PathPlace> placeOnPath(const Path2& path, const Eigen::Vector2d& p);

}  // namespace frugal_nav
