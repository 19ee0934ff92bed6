#pragma once

#include <functional>
#include <optional>
#include <string>

#include <nav_msgs/Odometry.h>
#include <ros/ros.h>

#include <frugal_nav/common/odometry_buffer.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/intake_params.hpp>
#include <frugal_nav/ros/time_jump_watch.hpp>

namespace frugal_nav {

/// The topic odom, kept for the last seconds, so that a sensor reading gets the pose of its own stamp.
class OdometryIntake {
 public:
  /// `arrived` is called after each sound message. Stamps go to `time`.
  OdometryIntake(ros::NodeHandle nh, const IntakeParams& params, NodeDiagnostics& diagnostics,
                 TimeJumpWatch& time, std::function<void()> arrived);
  OdometryIntake(const OdometryIntake&) = delete;  // the subscription holds its address
  OdometryIntake& operator=(const OdometryIntake&) = delete;

  /// What is known for a reading's stamp (`what` names it: "scan"): its odometry; or the fault for which
  /// there will be none; or neither yet, while the reading has waited for less than odom_wait_s of ROS time.
  struct Answer {
    std::optional<Odometry> odometry;
    std::string fault;

    bool isFinal() const { return odometry || !fault.empty(); }
  };
  Answer at(const std::string& what, Stamp stamp, double waited_s) const;

  /// After a jump back in time.
  void clear() { buffer_.clear(); }

 private:
  void onOdometry(const nav_msgs::Odometry& msg);

  IntakeParams params_;
  NodeDiagnostics& diagnostics_;
  TimeJumpWatch& time_;
  std::function<void()> arrived_;
  OdometryBuffer buffer_;
  ros::Subscriber subscriber_;
};

}  // namespace frugal_nav
