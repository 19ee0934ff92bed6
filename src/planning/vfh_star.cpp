#include <algorithm>
#include <cmath>
#include <queue>

#include <frugal_nav/planning/vfh_star.hpp>

namespace frugal_nav {
namespace {

/// The pose after `length_m` of driving toward a direction: along the smallest circle, then straight.
Pose2 drive(const Pose2& from, double direction_rad, double radius_m, double length_m) {
  const double turn = angleBetween(from.yaw_rad, direction_rad);
  const double on_circle_m = std::min(radius_m * std::abs(turn), length_m);
  const double turned = radius_m > 0.0 ? std::copysign(on_circle_m / radius_m, turn) : turn;
  const Pose2 after_circle = from * arcMotion({on_circle_m, turned}, 1.0);
  return after_circle * Pose2{length_m - on_circle_m, 0.0, 0.0};
}

}  // namespace

VfhStar::Node VfhStar::step(const Node& from, double direction_rad, const Place& place) const {
  const double target = directionTo(from.odom_from_base, place.target_odom);
  const double weight = std::pow(params().discount, from.depth);
  Node node = from;
  node.cost += weight * cost(direction_rad, target, from.odom_from_base.yaw_rad, from.previous_rad);
  node.odom_from_base = drive(from.odom_from_base, direction_rad, place.turning_radius_m, params().step_m);
  node.previous_rad = direction_rad;
  node.depth = from.depth + 1;
  node.estimate = node.cost + estimate(node, place);
  return node;
}

// The next step costs at least this: straight at the target, which costs a turn away from heading and
// previous.
double VfhStar::estimate(const Node& node, const Place& place) const {
  if (node.depth >= params().depth) return 0.0;
  const double target = directionTo(node.odom_from_base, place.target_odom);
  return std::pow(params().discount, node.depth) *
         cost(target, target, node.odom_from_base.yaw_rad, node.previous_rad);
}

double VfhStar::choose(const Place& place, const std::vector<double>& candidates,
                       const std::vector<WindowPoint>& points) const {
  const auto later = [](const Node& a, const Node& b) {
    return a.estimate != b.estimate ? a.estimate > b.estimate : a.depth < b.depth;
  };
  std::priority_queue<Node, std::vector<Node>, decltype(later)> open(later);
  Node start;
  start.odom_from_base = place.odom_from_base;
  start.previous_rad = previous(directionTo(place.odom_from_base, place.target_odom));
  for (const double direction : candidates) {
    Node node = step(start, direction, place);
    node.first_rad = direction;
    open.push(node);
  }
  Node deepest = open.top();
  for (int places = 0; !open.empty() && places < params().most_places; ++places) {
    const Node node = open.top();
    open.pop();
    if (node.depth > deepest.depth) deepest = node;
    const double left_m = (place.target_odom - node.odom_from_base.position()).norm();
    if (node.depth >= params().depth || left_m < params().step_m) return node.first_rad;
    Place there = place;
    there.odom_from_base = node.odom_from_base;
    const double target = directionTo(node.odom_from_base, place.target_odom);
    for (const double direction : histogramAt(there, points, nullptr).candidates(target))
      open.push(step(node, direction, place));
  }
  return deepest.first_rad;
}

}  // namespace frugal_nav
