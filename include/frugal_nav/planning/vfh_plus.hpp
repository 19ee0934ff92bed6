#pragma once

#include <optional>
#include <vector>

#include <frugal_nav/planning/local_planner.hpp>
#include <frugal_nav/planning/polar_histogram.hpp>
#include <frugal_nav/planning/speed_choice.hpp>

namespace frugal_nav {

struct VfhParams {
  HistogramParams histogram;
  double safety_m = 0.08;
  double least_safety_m = 0.012;
  int narrowings = 3;
  double near_rad = 0.35;
  double max_detour_rad = 1.05;
  double goal_margin_m = 0.20;
  double mu_target = 5.0;
  double mu_heading = 2.0;
  double mu_previous = 2.0;
  double turn_time_s = 3.0;
  int depth = 4;
  double step_m = 0.4;
  double discount = 0.8;
  int most_places = 40;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("histogram", histogram);
    visit("safety_m", safety_m, Field{"m", "air kept beside the body where there is room", 0.0, 1.0});
    visit("least_safety_m", least_safety_m,
          Field{"m", "air kept in the narrowest passage: noise of the scan and of the steering", 0.0, 1.0});
    visit("narrowings", narrowings, Field{"", "steps from safety_m to least_safety_m", 1, 10});
    visit(
        "near_rad", near_rad,
        Field{"rad", "a direction this near to the target's is taken without asking what less air would open",
              0.0, 3.1416});
    visit(
        "max_detour_rad", max_detour_rad,
        Field{"rad",
              "a direction farther than this from the target's is taken only when less air opens none nearer",
              0.0, 3.1416});
    visit("goal_margin_m", goal_margin_m,
          Field{"m", "obstacles farther than the target by more than this do not count", 0.0, 2.0});
    visit("mu_target", mu_target,
          Field{"", "cost of a direction's angle to the target; above the sum of the others", 0.0, 100.0});
    visit("mu_heading", mu_heading, Field{"", "of its angle to the robot's heading", 0.0, 100.0});
    visit("mu_previous", mu_previous, Field{"", "of its angle to the direction chosen before", 0.0, 100.0});
    visit("turn_time_s", turn_time_s,
          Field{"s", "report blocked after turning on the spot this long", 0.0, 60.0});
    visit("depth", depth, Field{"", "VFH*: steps it looks ahead", 1, 10});
    visit("step_m", step_m, Field{"m", "VFH*: way driven in a step before it looks again", 0.05, 2.0});
    visit("discount", discount, Field{"", "VFH*: a step's cost over that of the step before", 0.1, 1.0});
    visit("most_places", most_places,
          Field{"", "VFH*: places it looks from at most, to bound the time", 1, 1000});
  }
  std::string check() const {
    if (least_safety_m > safety_m) return "least_safety_m is above safety_m";
    return mu_target > mu_heading + mu_previous ? "" : "mu_target must be above mu_heading + mu_previous";
  }
};

/// VFH+ (Ulrich and Borenstein, 1998): of the candidate directions of the masked polar histogram the one with
/// the least cost mu1 D(c, target) + mu2 D(c, heading) + mu3 D(c, previous).
///
/// Where no candidate lies near the target's direction the safety distance shrinks in steps; without any, the
/// robot turns toward the larger clearance.
class VfhPlus : public LocalPlanner {
 public:
  /// What was decided on one scan, for display.
  struct Decision {
    SectorRing binary;
    SectorRing masked;
    std::vector<double> candidates_odom_rad;
    std::optional<double> chosen_odom_rad;
    double safety_m = 0.0;
  };

  /// Throws ConfigError on parameters out of range.
  VfhPlus(const VfhParams& params, const SpeedParams& speed, const BodyExtent& body);

  MotionCommand plan(const LocalPlannerInput& input) override;
  void reset() override;

  const Decision& decision() const { return decision_; }

 protected:
  /// A place of the robot on its way to the target, from which a direction is chosen.
  struct Place {
    Pose2 odom_from_base;
    Eigen::Vector2d target_odom;
    double turning_radius_m = 0.0;
    double enlargement_m = 0.0;
  };

  /// The direction to take from the robot's place, given its candidates; overridden by those that look ahead.
  virtual double choose(const Place& place, const std::vector<double>& candidates,
                        const std::vector<WindowPoint>& points) const;
  /// Direction in odom from a place to a point [rad].
  static double directionTo(const Pose2& from, const Eigen::Vector2d& p);
  double cost(double direction_rad, double target_rad, double heading_rad, double previous_rad) const;
  PolarHistogram histogramAt(const Place& place, const std::vector<WindowPoint>& points,
                             const SectorRing* previous) const;
  const VfhParams& params() const { return params_; }
  double previous(double otherwise_rad) const { return previous_odom_rad_.value_or(otherwise_rad); }

 private:
  bool decide(const LocalPlannerInput& input, const std::vector<WindowPoint>& points,
              const std::vector<Eigen::Vector2d>& p_base);
  void takeDetour(const LocalPlannerInput& input, const std::vector<Eigen::Vector2d>& p_base,
                  double target_rad, const std::vector<Decision>& others);
  double turningRadius(const Twist2& twist) const;
  MotionCommand turn(const LocalPlannerInput& input, MotionCommand command);

  VfhParams params_;
  BodyExtent body_;
  SpeedChoice speed_;
  Decision decision_;
  std::vector<SectorRing> previous_;  ///< the last binary histogram of each safety distance
  std::optional<double> previous_odom_rad_;
  std::optional<Stamp> turning_since_;
};

}  // namespace frugal_nav
