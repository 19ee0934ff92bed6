#pragma once

#include <vector>

#include <frugal_nav/planning/vfh_plus.hpp>

namespace frugal_nav {

/// VFH* (Ulrich and Borenstein, 2000): VFH+ that looks ahead.
///
/// Each candidate is driven in thought for a step; from there the histogram gives candidates again, `depth`
/// times. A* finds the cheapest sequence, later steps counting less, and its first direction is taken: so a
/// direction that ends in a dead end, though it looks best from here, is not.
class VfhStar : public VfhPlus {
 public:
  using VfhPlus::VfhPlus;

 protected:
  double choose(const Place& place, const std::vector<double>& candidates,
                const std::vector<WindowPoint>& points) const override;

 private:
  struct Node {
    Pose2 odom_from_base;
    double first_rad = 0.0;     ///< direction of the sequence's first step
    double previous_rad = 0.0;  ///< of its last
    double cost = 0.0;
    double estimate = 0.0;  ///< of the whole sequence: never above the truth
    int depth = 0;
  };

  Node step(const Node& from, double direction_rad, const Place& place) const;
  double estimate(const Node& node, const Place& place) const;
};

}  // namespace frugal_nav
