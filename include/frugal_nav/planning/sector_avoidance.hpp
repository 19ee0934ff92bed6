#pragma once

#include <optional>
#include <vector>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/planning/body_extent.hpp>
#include <frugal_nav/planning/local_planner.hpp>
#include <frugal_nav/planning/sector_ring.hpp>

namespace frugal_nav {

struct SectorParams {
  int sectors = 72;
  double block_distance_m = 1.0;
  double block_half_width_rad = 0.436332;
  double step_m = 0.5;
  double goal_margin_m = 0.20;
  double max_detour_rad = 0.785398;
  double tie_rad = 0.0872665;
  int narrowings = 3;
  double first_margin_m = 0.10;
  double last_margin_m = 0.04;
  double first_distance_m = 0.70;
  double last_distance_m = 0.40;
  double turn_rate_radps = 0.6;
  double turn_time_s = 3.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("sectors", sectors,
          Field{"", "directions around the robot; 72 are 5 degrees each [paper]", 8, 360});
    visit("block_distance_m", block_distance_m,
          Field{"m", "a return nearer than this blocks its sector [paper]", 0.1, 10.0});
    visit(
        "block_half_width_rad", block_half_width_rad,
        Field{
            "rad",
            "a blocked sector blocks this far to each side; 25 degrees [paper], and never less than what the "
            "body needs beside the obstacle",
            0.0, 1.5708});
    visit("step_m", step_m,
          Field{"m", "longest step; every scan decides anew on the way [paper]", 0.05, 5.0});
    visit("goal_margin_m", goal_margin_m,
          Field{"m",
                "returns farther than the target by more than this do not count: a goal in front of a wall",
                0.0, 2.0});
    visit("max_detour_rad", max_detour_rad,
          Field{"rad",
                "a free sector farther than this from the wanted direction is taken only when narrower "
                "blocking frees none nearer; pi takes the paper's first free sector wherever it points",
                0.0, 3.1416});
    visit("tie_rad", tie_rad,
          Field{"rad",
                "free sectors whose detours differ by less are equal: the previous direction decides; one "
                "sector",
                0.0, 1.0});
    visit("narrowings", narrowings,
          Field{"", "how many times narrower blocking is tried where nothing is free", 0, 10});
    visit("first_margin_m", first_margin_m,
          Field{"m",
                "room beside the body at the first narrowing, where a return blocks the angle that the "
                "body's half "
                "width and this subtend at its distance",
                0.0, 1.0});
    visit("last_margin_m", last_margin_m,
          Field{"m", "room beside the body at the last narrowing: noise of the scan and of the steering", 0.0,
                1.0});
    visit("first_distance_m", first_distance_m,
          Field{"m", "distance within which returns block at the first narrowing", 0.1, 10.0});
    visit("last_distance_m", last_distance_m,
          Field{"m", "likewise at the last: braking distance and the body's front", 0.1, 10.0});
    visit("turn_rate_radps", turn_rate_radps,
          Field{"rad/s", "turn on the spot toward the larger clearance when nothing is free", 0.05, 3.0});
    visit("turn_time_s", turn_time_s, Field{"s", "report blocked after turning this long", 0.0, 60.0});
  }
  /// Names fields that contradict each other; empty when sound.
  std::string check() const;
};

/// The sector method of LIDAR avoidance: drive a step in the free sector nearest to the wanted direction.
///
/// A sector is blocked when a return lies in it within block_distance_m, and blocks its neighbours within
/// block_half_width_rad. Where that leaves nothing within max_detour_rad of the wanted direction, blocking is
/// narrowed in steps from the paper's fixed angle to the angle that the body's half width plus a margin
/// subtends at each obstacle, within a shorter distance. A sector the scan says nothing about is never driven
/// in.
class SectorAvoidance : public LocalPlanner {
 public:
  /// What was decided on one scan, for display: the ring of the chosen narrowing, 0 being the paper's.
  struct Decision {
    SectorRing ring;
    int narrowing = 0;
    bool found = false;
    double bearing_rad = 0.0;              ///< in base_link
    double reach_m = 0.0;                  ///< how far that direction was checked
    std::vector<double> candidates_rad{};  ///< directions it was chosen from, in base_link; of vfh_*
  };

  SectorAvoidance(const SectorParams& params, const BodyExtent& body);

  MotionCommand plan(const LocalPlannerInput& input) override;
  void reset() override;

  const Decision& decision() const { return decision_; }

 private:
  struct Blocking {
    double distance_m;
    double half_width_rad;     ///< fixed part of what a return blocks to each side
    double body_half_width_m;  ///< and never less than what this subtends
  };
  struct Wanted {
    double bearing_rad;
    double distance_m;
  };

  Blocking blocking(int narrowing) const;
  SectorRing block(const Blocking& rule, const LocalPlannerInput& input, double target_distance_m,
                   const std::vector<bool>& observed) const;
  std::optional<double> choose(const SectorRing& ring, double wanted_rad, double max_detour_rad,
                               double heading_rad) const;
  Decision decide(const LocalPlannerInput& input, const Wanted& wanted,
                  const std::vector<bool>& observed) const;
  MotionCommand drive(const LocalPlannerInput& input, const Wanted& wanted, MotionCommand command);
  MotionCommand turn(const LocalPlannerInput& input, MotionCommand command);

  SectorParams params_;
  BodyExtent body_;
  Decision decision_;
  std::optional<double> previous_odom_rad_;  ///< direction of the last step, in odom
  std::optional<Stamp> turning_since_;
};

}  // namespace frugal_nav
