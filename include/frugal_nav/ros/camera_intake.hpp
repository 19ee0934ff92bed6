#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>

#include <frugal_nav/Gap.h>
#include <frugal_nav/Obstacle.h>
#include <frugal_nav/planning/camera_planner.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/intake_params.hpp>
#include <frugal_nav/ros/odometry_intake.hpp>
#include <frugal_nav/ros/time_jump_watch.hpp>

namespace frugal_nav {

/// What depth_gap says of one image, put together: gap, obstacle/nearest and depth/scan of one stamp, with
/// the odometry of that stamp.
///
/// Each image for which one of them came is handed on once, in the order of stamps: complete; or with a fault
/// when something is bad, does not come in time, or a later image is complete before.
class CameraIntake {
 public:
  using Process = std::function<void(const CameraObservation&)>;

  /// Stamps go to `time`.
  CameraIntake(ros::NodeHandle nh, const IntakeParams& params, double input_wait_s,
               NodeDiagnostics& diagnostics, TimeJumpWatch& time, Process process);
  CameraIntake(const CameraIntake&) = delete;  // subscriptions hold its address
  CameraIntake& operator=(const CameraIntake&) = delete;

  /// Hands on what can be, now that time has passed.
  void process();
  /// After a jump back in time.
  void clear();

 private:
  struct Pending {
    CameraObservation observation;
    bool has_gap = false;
    bool has_obstacle = false;
    bool has_scan = false;
    ros::Time since;
    bool isWhole() const { return has_gap && has_obstacle && has_scan; }
  };

  void onGap(const Gap& msg);
  void onObstacle(const Obstacle& msg);
  void onScan(const sensor_msgs::LaserScan& msg);
  /// The image an input belongs to; null, counted as dropped, for one that has been handed on already.
  Pending* pendingFor(const std::string& input, const std_msgs::Header& header, const std::string& frame);
  bool complete(Pending& pending, bool later_is_whole);

  IntakeParams params_;
  double input_wait_s_;
  NodeDiagnostics& diagnostics_;
  TimeJumpWatch& time_;
  Process process_;
  OdometryIntake odometry_;
  std::map<Stamp, Pending> pending_;
  std::optional<Stamp> handed_on_;
  ros::Subscriber gap_sub_;
  ros::Subscriber obstacle_sub_;
  ros::Subscriber scan_sub_;
};

}  // namespace frugal_nav
