#pragma once

#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// How the collision stop looks ahead.
struct CollisionGuardParams {
  double margin_m = 0.025;
  double slow_margin_m = 0.010;
  double slow_mps = 0.10;
  double full_mps = 0.20;
  double reaction_s = 0.10;
  double hold_s = 0.05;
  double brake_mps2 = 1.5;
  double turn_brake_radps2 = 8.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("margin_m", margin_m,
          Field{"m", "air kept around the footprint: five standard deviations of a scan at half a metre", 0.0,
                1.0});
    visit("slow_margin_m", slow_margin_m,
          Field{"m",
                "the same when driving slowly, so that narrow passages are passed: what a scan errs close by",
                0.0, 1.0});
    visit("slow_mps", slow_mps,
          Field{"m/s", "up to this speed of the footprint's fastest corner that margin is enough", 0.0, 5.0});
    visit("full_mps", full_mps, Field{"m/s", "and from this on the whole margin is kept", 0.01, 5.0});
    visit("reaction_s", reaction_s,
          Field{"s", "for this long the present velocity goes on: motor lag and transport", 0.0, 1.0});
    visit("hold_s", hold_s,
          Field{"s", "for this long a command holds before the next: one control cycle", 0.0, 1.0});
    visit("brake_mps2", brake_mps2,
          Field{"m/s^2", "deceleration of an emergency stop: half of what the motors reach", 0.05, 20.0});
    visit("turn_brake_radps2", turn_brake_radps2,
          Field{"rad/s^2", "deceleration of a turn in an emergency stop", 0.1, 100.0});
  }
  std::string check() const {
    if (full_mps <= slow_mps) return "full_mps must exceed slow_mps";
    return slow_margin_m <= margin_m ? "" : "slow_margin_m must not exceed margin_m";
  }
};

/// What the collision stop left of a command.
struct GuardedTwist {
  Twist2 velocity;
  double share = 1.0;  ///< of the command, or of its turn rate alone or its speed alone; 0: stopped
};

/// Scales commands down until the footprint, driven along them and then stopped, touches no point.
///
/// The way simulated is: the present velocity during `reaction_s`; the command, reached by braking where it
/// is slower, while it holds and for as long as the scan is old (what it shows may have come nearer
/// meanwhile); then braking, speed and turn each by its own deceleration. Clearance is that of the
/// footprint's edge lines, which is less than the true distance beside a corner. Where a point is already
/// within the margin, motion is allowed as long as that clearance does not shrink.
class CollisionGuard {
 public:
  /// The footprint is convex, counter-clockwise, in base_link. Throws ConfigError when it is not, or on
  /// parameters out of range.
  CollisionGuard(const CollisionGuardParams& params, const Polygon2& footprint);

  /// The largest share of a command that touches nothing: all of it, 3/4, 1/2, 1/4, then turning alone, then
  /// driving slowly on another arc, the next to the commanded one, then zero.
  GuardedTwist check(const Twist2& command, const Twist2& present, double scan_age_s,
                     const std::vector<Eigen::Vector2d>& p_base) const;
  /// How far the robot can drive along a velocity's arc before the margin touches a point [m]; `horizon_m`
  /// when nothing is touched that far, and for a turn on the spot.
  double freeDistance(const Twist2& velocity, double horizon_m,
                      const std::vector<Eigen::Vector2d>& p_base) const;
  /// Distance from the footprint's edge lines, negative inside [m].
  double clearance(const Eigen::Vector2d& p_base) const;
  /// How far from a point within it the footprint ends in a direction [m]; 0 from outside.
  double wayOut_m(const Eigen::Vector2d& p_base, const Eigen::Vector2d& direction) const;

 private:
  struct Edge {
    Eigen::Vector2d outward;
    double offset_m;
  };
  struct Way {
    std::vector<Pose2> poses;  // base at the start from base later
    double length_m = 0.0;
  };

  Twist2 bent(const Twist2& command, double turn_radps) const;
  double marginAt(const Twist2& velocity) const;
  void drive(Way& way, const Twist2& begin, const Twist2& end, double duration_s) const;
  double ramp(Way& way, const Twist2& begin, const Twist2& end) const;
  Way stoppingWay(const Twist2& command, const Twist2& present, double hold_s) const;
  bool isFree(const Way& way, double margin_m, const std::vector<Eigen::Vector2d>& p_base) const;
  bool keepsClear(const Pose2& start_from_pose, double margin_m,
                  const std::vector<Eigen::Vector2d>& p_base) const;
  std::vector<Eigen::Vector2d> within(double reach_m, const std::vector<Eigen::Vector2d>& p_base) const;

  CollisionGuardParams params_;
  std::vector<Edge> edges_;
  double circumradius_m_ = 0.0;
};

}  // namespace frugal_nav
