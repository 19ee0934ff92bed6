#pragma once

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/odometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// How a stuck robot gets itself out.
struct RecoveryParams {
  int max_recoveries = 4;
  double turn_radps = 0.6;
  double turn_tolerance_rad = 0.15;
  double turn_timeout_s = 8.0;
  double back_off_m = 0.25;
  double back_off_mps = 0.10;
  double back_off_timeout_s = 5.0;
  double regained_m = 1.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("max_recoveries", max_recoveries,
          Field{"", "recoveries in one place before the goal is given up", 0.0, 100.0});
    visit("turn_radps", turn_radps, Field{"rad/s", "turn rate toward the clear side", 0.05, 3.0});
    visit("turn_tolerance_rad", turn_tolerance_rad,
          Field{"rad", "faces the clear side when within this", 0.02, 1.0});
    visit(
        "turn_timeout_s", turn_timeout_s,
        Field{"s", "a turn that takes longer is held up; half a turn at turn_radps takes 5.2 s", 0.5, 60.0});
    visit("back_off_m", back_off_m, Field{"m", "way back: about one robot length", 0.0, 2.0});
    visit("back_off_mps", back_off_mps,
          Field{"m/s", "slow, since the camera does not see what lies behind", 0.01, 0.5});
    visit("back_off_timeout_s", back_off_timeout_s,
          Field{"s", "backing off that takes longer is held up", 0.5, 60.0});
    visit("regained_m", regained_m,
          Field{"m", "progress after which earlier recoveries no longer count: another place", 0.1, 100.0});
  }
};

/// One recovery: turn toward the clear side, then back off slowly. A step that is held up, by the collision
/// stop for one, ends with its time-out. Gives velocities in base_link; the collision stop stands over them.
class Recovery {
 public:
  explicit Recovery(const RecoveryParams& params) : params_(params) {}
  void setParams(const RecoveryParams& params) { params_ = params; }

  /// Begins at the present pose; `clear_bearing_rad` is the direction of the larger clearance, in base_link.
  /// Without `backs_off` it only turns: where nothing sees what lies behind.
  void start(const Odometry& odometry, double clear_bearing_rad, bool backs_off = true);
  /// The velocity for this instant; zero once done.
  Twist2 update(const Odometry& odometry);
  bool done() const { return step_ == Step::kDone; }

 private:
  enum class Step { kTurn, kBackOff, kDone };
  Twist2 turn(const Odometry& odometry);
  Twist2 backOff(const Odometry& odometry);
  void enter(Step step, const Odometry& odometry);

  RecoveryParams params_;
  Step step_ = Step::kDone;
  Stamp step_start_{};
  Pose2 step_pose_;
  double goal_yaw_rad_ = 0.0;  ///< in odom
  bool backs_off_ = true;
};

}  // namespace frugal_nav
