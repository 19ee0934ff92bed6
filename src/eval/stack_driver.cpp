#include "stack_driver.hpp"

#include <algorithm>

namespace frugal_nav::eval {

StackDriver::StackDriver(const LidarStackParams& params, const RobotModel& robot, const Pose2& odom_from_goal,
                         Stamp now)
    : stack_(params, robot) {
  stack_.setGoal(odom_from_goal, now);
}

Twist2 StackDriver::addTicks(const sim::WheelTicks& ticks) {
  return stack_.addTicks(ticks.stamp, ticks.left, ticks.right).velocity;
}

Twist2 StackDriver::addScan(const LaserScan& scan) {
  recoveries_ = std::max(recoveries_, stack_.mission().recoveries());
  return stack_.addScan(scan).velocity;
}

bool StackDriver::reached() const { return stack_.mission().status().phase == MissionPhase::kReached; }

std::string StackDriver::abortReason() const {
  const MissionStatus& status = stack_.mission().status();
  return status.phase == MissionPhase::kAborted ? status.reason : "";
}

}  // namespace frugal_nav::eval
