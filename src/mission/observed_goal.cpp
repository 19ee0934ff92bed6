#include <algorithm>
#include <cmath>

#include <frugal_nav/mission/observed_goal.hpp>

namespace frugal_nav {

void ObservedGoal::start(const Eigen::Vector2d& p_person, const Eigen::Vector2d& p_robot, Stamp stamp) {
  p_person_ = p_approach_person_ = p_person;
  const Eigen::Vector2d way = p_person - p_robot;
  stand_off_m_ = std::min(params_.stand_off_m, way.norm());  // never backward
  if (way.norm() > 1e-6) approach_ = way.normalized();
  unseen_s_ = 0.0;
  watched_ = stamp;
}

bool ObservedGoal::see(const Eigen::Vector2d& p_person, const Eigen::Vector2d& p_robot) {
  unseen_s_ = 0.0;
  if ((p_person - p_person_).norm() < params_.shift_m) return false;
  p_person_ = p_person;
  const Eigen::Vector2d way = p_person - p_robot;
  if ((p_person - p_approach_person_).norm() > params_.new_approach_m && way.norm() > params_.stand_off_m) {
    p_approach_person_ = p_person;
    approach_ = way.normalized();
    stand_off_m_ = params_.stand_off_m;
  }
  return true;
}

Pose2 ObservedGoal::standOff() const {
  const Eigen::Vector2d p = p_person_ - stand_off_m_ * approach_;
  return {p.x(), p.y(), std::atan2(approach_.y(), approach_.x())};
}

void ObservedGoal::watch(Stamp stamp, const Pose2& odom_from_base, double bend_m) {
  constexpr double kLongest_s = 0.5;  // longer ago, the mission was at something else
  const double since_s = watched_ ? toSeconds(stamp - *watched_) : 0.0;
  const double elapsed_s = since_s < kLongest_s ? std::max(since_s, 0.0) : 0.0;
  watched_ = stamp;
  if (shouldBeSeen(odom_from_base, bend_m)) unseen_s_ += elapsed_s;
}

bool ObservedGoal::shouldBeSeen(const Pose2& odom_from_base, double bend_m) const {
  // Near the edge of the view a head is cut.
  constexpr double kWhole = 0.85;
  const double distance_m = (p_person_ - odom_from_base.position()).norm();
  return distance_m > params_.nearest_in_view_m && distance_m < params_.farthest_in_view_m &&
         std::abs(bearingTo(odom_from_base, p_person_)) < kWhole * 0.5 * params_.view_rad &&
         bend_m < params_.hidden_by_m;
}

double bendOf(const Path2& path) {
  if (path.size() < 3) return 0.0;
  const Eigen::Vector2d way = path.back().position() - path.front().position();
  if (way.norm() < 1e-6) return 0.0;
  const Eigen::Vector2d along = way.normalized();
  double largest = 0.0;
  for (const Pose2& pose : path) {
    const Eigen::Vector2d p = pose.position() - path.front().position();
    largest = std::max(largest, std::abs(along.x() * p.y() - along.y() * p.x()));
  }
  return largest;
}

}  // namespace frugal_nav
