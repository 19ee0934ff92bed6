#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <nodelet/nodelet.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>

#include <frugal_nav/LocalCommand.h>
#include <frugal_nav/MissionState.h>
#include <frugal_nav/Obstacle.h>
#include <frugal_nav/control/base_control.hpp>
#include <frugal_nav/ros/base_controller_params.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/last_word.hpp>
#include <frugal_nav/ros/live_parameters.hpp>
#include <frugal_nav/ros/sensor_poses.hpp>

namespace frugal_nav {

/// The only publisher of cmd_vel. One control cycle for each mission/state and avoidance/command, for each
/// path in mode camera, and from a timer when none came; each publishes one cmd_vel and one cmd_vel_stamped.
class BaseControllerNode {
 public:
  /// Throws ConfigError on bad parameters or a missing robot_description.
  BaseControllerNode(ros::NodeHandle nh, ros::NodeHandle pnh);
  ~BaseControllerNode();
  BaseControllerNode(const BaseControllerNode&) = delete;  // callbacks hold its address
  BaseControllerNode& operator=(const BaseControllerNode&) = delete;

  /// Publishes zero velocity, and no more after it.
  void stop();

 private:
  /// A cycle that waits for the messages that belong to its trigger: topics arrive in any order.
  struct Pending {
    Stamp stamp;  ///< of the trigger, and of the command
    Stamp odom;
    Stamp scan;
    Stamp mission_command;
    Stamp camera;  ///< of obstacle/nearest, and of depth/scan once one has come
  };

  void onMissionState(const MissionState& msg);
  void onOdometry(const nav_msgs::Odometry& msg);
  void onScan(const sensor_msgs::LaserScan& msg);
  void onLocalCommand(const LocalCommand& msg);
  void onPath(const nav_msgs::Path& msg);
  void onObstacle(const Obstacle& msg);
  void onDepthScan(const sensor_msgs::LaserScan& msg);
  void onMissionCommand(const geometry_msgs::TwistStamped& msg);
  void onManualCommand(const geometry_msgs::TwistStamped& msg);
  void onTimer();

  void note(const std::string& topic, bool accepted, Stamp stamp);
  void request(const Pending& pending);
  void cycleWhenReady();
  void cycle();
  void publish(const Twist2& velocity, Stamp stamp);
  void report(const BaseCommand& command);
  void show(const BaseCommand& command) const;

  BaseControllerNodeParams params_;
  BaseControl control_;
  NodeDiagnostics diagnostics_;
  std::unique_ptr<LiveParameterServer> tuning_;
  SensorPoses sensors_;

  std::optional<Pending> pending_;
  Stamp odom_stamp_{};
  Stamp scan_stamp_{};
  Stamp mission_command_stamp_{};
  Stamp obstacle_stamp_{};
  std::optional<Stamp> depth_stamp_;
  ros::Time last_cycle_;
  // The command's stamp is its trigger's, not that of the newest input: it answers one sensor message, and
  // who waits for that answer does not take another command for it.
  Stamp stamp_{};
  BaseCommand last_;
  std::uint64_t reported_jumps_ = 0;
  bool stopped_ = false;

  ros::Publisher cmd_vel_pub_;
  ros::Publisher cmd_vel_stamped_pub_;
  ros::Publisher markers_pub_;
  std::vector<ros::Subscriber> subscribers_;
  ros::Timer timer_;
};

/// The base controller as a nodelet: it must stop the base before its manager ends.
class BaseControllerNodelet : public nodelet::Nodelet {
 private:
  void onInit() override;

  std::unique_ptr<BaseControllerNode> node_;
  std::unique_ptr<LastWord> last_word_;
};

}  // namespace frugal_nav
