#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>

#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>

#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/goal_intake.hpp>
#include <frugal_nav/ros/intake_params.hpp>
#include <frugal_nav/ros/odometry_intake.hpp>
#include <frugal_nav/ros/sensor_poses.hpp>
#include <frugal_nav/ros/silence_watch.hpp>
#include <frugal_nav/ros/time_jump_watch.hpp>

namespace frugal_nav {

/// A scan with the pose it was taken at; or the reason why it cannot be used.
struct PosedScan {
  LaserScan scan;
  std::string frame;
  Pose2 base_from_laser;
  Odometry odometry;  ///< at the scan's stamp
  std::string fault;  ///< empty: all of the above holds
};

/// The inputs that planner and lidar_avoidance share: scan, odom, mission/state and mission/goal.
///
/// A scan is handed on, in the order of stamps, once odometry of its stamp or later is in and `ready` agrees,
/// or with a fault once it has waited too long: one call of `process` for each scan, whatever happens. A
/// stamp or ROS time that goes back forgets everything and calls `time_jumped`.
class ScanIntake {
 public:
  struct Callbacks {
    std::function<bool(const PosedScan&)> ready;  ///< may hold a sound scan back; asked again at each input
    std::function<void(const PosedScan&)> process;
    std::function<void()> time_jumped;
  };

  ScanIntake(ros::NodeHandle nh, const IntakeParams& params, const ScanRules& rules,
             NodeDiagnostics& diagnostics, Callbacks callbacks);
  ScanIntake(const ScanIntake&) = delete;  // subscriptions hold its address
  ScanIntake& operator=(const ScanIntake&) = delete;

  /// Where to go, in odom, while the mission drives there by LIDAR; otherwise nothing.
  std::optional<Pose2> goal() const { return goal_.goal(); }
  /// The mission's number of that goal.
  std::uint32_t goalNumber() const { return goal_.number(); }
  /// How scans are read from the next one on.
  void setRules(const ScanRules& rules) { rules_ = rules; }
  /// Hands on every scan that can be; to be called when what `ready` waits for has come.
  void process();
  /// Checks the stamp of a further input of the node: one that goes back is a jump in time.
  void checkStamp(const std::string& input, Stamp stamp) { time_.checkStamp(input, stamp); }
  /// How long the scan handed to `ready` has waited, in ROS time [s].
  double waited_s() const;

 private:
  struct Pending {
    PosedScan posed;
    ros::Time since;
  };

  void onScan(const sensor_msgs::LaserScan& msg);
  void onTimer();
  void watchSilence();
  void forget(Stamp now);
  bool complete(Pending& pending);

  IntakeParams params_;
  ScanRules rules_;
  NodeDiagnostics& diagnostics_;
  Callbacks callbacks_;
  TimeJumpWatch time_;
  SensorPoses sensors_;
  GoalIntake goal_;
  OdometryIntake odometry_;
  std::deque<Pending> pending_;
  std::optional<Stamp> last_scan_;
  SilenceWatch silence_;

  ros::Subscriber scan_sub_;
  ros::Timer timer_;
};

}  // namespace frugal_nav
