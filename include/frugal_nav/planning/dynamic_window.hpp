#pragma once

#include <vector>

#include <frugal_nav/planning/local_planner.hpp>
#include <frugal_nav/planning/speed_choice.hpp>

namespace frugal_nav {

struct DynamicWindowParams {
  int speeds = 6;
  int turns = 21;
  double accel_mps2 = 0.6;
  double turn_accel_radps2 = 4.0;
  double period_s = 0.1;
  double horizon_m = 1.5;
  double heading_after_s = 0.5;
  double margin_m = 0.03;
  double heading_weight = 2.0;
  double clearance_weight = 0.4;
  double speed_weight = 0.4;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("speeds", speeds, Field{"", "speeds tried, evenly over what can be reached", 2, 50});
    visit("turns", turns, Field{"", "turn rates tried, likewise", 3, 101});
    visit("accel_mps2", accel_mps2, Field{"m/s^2", "base_controller's limits/accel_mps2", 0.05, 20.0});
    visit("turn_accel_radps2", turn_accel_radps2,
          Field{"rad/s^2", "base_controller's limits/turn_accel_radps2", 0.1, 100.0});
    visit("period_s", period_s, Field{"s", "time to the next command: a scan's period", 0.01, 1.0});
    visit("horizon_m", horizon_m,
          Field{"m", "arcs are followed this far; farther obstacles do not count", 0.1, 10.0});
    visit("heading_after_s", heading_after_s,
          Field{"s", "the angle to the target counts after this time on the arc", 0.0, 5.0});
    visit("margin_m", margin_m, Field{"m", "air kept around the footprint", 0.0, 1.0});
    visit("heading_weight", heading_weight, Field{"", "alpha: of the angle to the target", 0.0, 100.0});
    visit("clearance_weight", clearance_weight,
          Field{"", "beta: of the way to the next obstacle", 0.0, 100.0});
    visit("speed_weight", speed_weight, Field{"", "gamma: of the speed", 0.0, 100.0});
  }
};

/// The dynamic window approach (Fox, Burgard and Thrun, 1997): of the velocities that the robot can reach by
/// the next command and stop from before its footprint touches anything, the one with the largest smoothed
/// alpha heading + beta clearance + gamma speed, each within [0, 1].
class DynamicWindow : public LocalPlanner {
 public:
  /// Throws ConfigError on parameters out of range.
  DynamicWindow(const DynamicWindowParams& params, const SpeedParams& speed, const BodyExtent& body);

  MotionCommand plan(const LocalPlannerInput& input) override;
  void reset() override {}

 private:
  struct Choice {
    Twist2 velocity;
    bool admissible = false;
    double value = 0.0;
  };

  double freeWay(const Twist2& velocity, const std::vector<Eigen::Vector2d>& obstacles_base) const;
  bool isAdmissible(const Twist2& velocity, double way_m) const;
  double value(const Twist2& velocity, double way_m, const Eigen::Vector2d& target_base) const;
  std::vector<Choice> rate(const Twist2& present, const Eigen::Vector2d& target_base, double fastest_mps,
                           const std::vector<Eigen::Vector2d>& obstacles_base) const;
  const Choice* best(const std::vector<Choice>& choices) const;

  DynamicWindowParams params_;
  SpeedChoice speed_;
  BodyExtent body_;
};

}  // namespace frugal_nav
