#include <cmath>

#include <frugal_nav/mission/mission.hpp>

// A place of a map as the goal: it moves in odom as the robot learns where it is.

namespace frugal_nav {
namespace {

// A goal that moves by less stays where it is: the robot's own place in a map is no better known, and the
// planner need not start anew with every image.
constexpr double kGoalShift_m = 0.05;
constexpr double kGoalShift_rad = 0.05;

}  // namespace

void Mission::moveGoal(const Pose2& odom_from_goal) {
  if (!active() || following_ || !odom_from_goal.isFinite()) return;
  hold_reason_.clear();
  const double turn_rad = angleBetween(odom_from_goal_.yaw_rad, odom_from_goal.yaw_rad);
  if (distance(odom_from_goal_, odom_from_goal) < kGoalShift_m && std::abs(turn_rad) < kGoalShift_rad) return;
  odom_from_goal_ = odom_from_goal;
  ++goal_changes_;
}

void Mission::holdGoal(const std::string& reason) {
  if (active() && !following_) hold_reason_ = reason;
}

Twist2 Mission::waitForMap(const Odometry& odometry) {
  if (hold_reason_.empty()) {
    progress_.resume(odometry.stamp);
    enter(Activity::kDriving, odometry.stamp, "driving to the goal, whose place is known again");
  } else if (toSeconds(odometry.stamp - activity_start_) >= params_.stopped_timeout_s) {
    finish(MissionPhase::kAborted, hold_reason_);
  }
  return {};
}

}  // namespace frugal_nav
