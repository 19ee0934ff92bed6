#pragma once

#include <cstdint>
#include <string>

#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/odometry_buffer.hpp>
#include <frugal_nav/control/base_control.hpp>
#include <frugal_nav/mission/mission.hpp>
#include <frugal_nav/odometry/wheel_odometry.hpp>
#include <frugal_nav/planning/lidar_avoidance.hpp>
#include <frugal_nav/planning/lidar_planner.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav::eval {

/// The parameters of every node between the sensors of mode lidar and cmd_vel.
struct LidarStackParams {
  WheelOdometryParams odometry;
  LidarPlannerParams planner;
  LidarAvoidanceParams avoidance;
  MissionParams mission;
  BaseControlParams base;
};

/// The nodes' own parameter files, read from a folder; what only the node class uses is left out. Files of
/// the same names in its subfolder `profile`, where there are any, hold what differs for a robot. Throws
/// ConfigError as loadParamFile().
LidarStackParams loadLidarStack(const std::string& config_dir, const std::string& profile = "simulated");

/// The node graph of mode lidar in one process: the same classes, called in the order in which the graph's
/// messages arrive. Each input leads to one command for the base, as each leads to one cmd_vel there.
class LidarStack {
 public:
  LidarStack(const LidarStackParams& params, const RobotModel& robot);

  /// A goal in odom, whose heading does not matter.
  void setGoal(const Pose2& odom_from_goal, Stamp stamp);
  /// Where that goal is in odom now.
  void moveGoal(const Pose2& odom_from_goal) { mission_.moveGoal(odom_from_goal); }

  /// ticks -> odometry -> mission -> base.
  BaseCommand addTicks(Stamp stamp, std::int64_t left, std::int64_t right);
  /// scan -> planner -> avoidance -> base.
  BaseCommand addScan(const LaserScan& scan);

  /// The newest odometry; at the origin of odom before the first ticks.
  const Odometry& odometry() const { return odometry_; }
  const Mission& mission() const { return mission_; }
  const LidarPlan& plan() const { return plan_; }
  const MotionCommand& localCommand() const { return local_; }

 private:
  void passGoal();

  bool uses_path_;
  Pose2 base_from_laser_;
  WheelOdometry wheels_;
  Mission mission_;
  LidarPlanner planner_;
  LidarAvoidance avoidance_;
  BaseControl base_;
  OdometryBuffer buffer_;
  Odometry odometry_;
  LidarPlan plan_;
  MotionCommand local_;
};

}  // namespace frugal_nav::eval
