#pragma once

#include "lidar_drive.hpp"

#include <frugal_nav/eval/lidar_stack.hpp>

namespace frugal_nav::eval {

/// The node graph's classes.
class StackDriver : public Driver {
 public:
  StackDriver(const LidarStackParams& params, const RobotModel& robot, const Pose2& odom_from_goal,
              Stamp now);

  Twist2 addTicks(const sim::WheelTicks& ticks) override;
  Twist2 addScan(const LaserScan& scan) override;
  Pose2 odometry() const override { return stack_.odometry().odom_from_base; }
  bool reached() const override;
  std::string abortReason() const override;
  int recoveries() const override { return recoveries_; }

 private:
  LidarStack stack_;
  int recoveries_ = 0;
};

}  // namespace frugal_nav::eval
