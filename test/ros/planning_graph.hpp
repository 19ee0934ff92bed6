#pragma once

#include <limits>
#include <string>

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>
#include <support/ros_test.hpp>
#include <tf2_ros/static_transform_broadcaster.h>
#include <unit/planning/flat_world.hpp>

#include <frugal_nav/MissionState.h>
#include <frugal_nav/ros/conversions.hpp>

namespace frugal_nav::test {

/// What surrounds planner and lidar_avoidance: a clock that stands between beats, a robot at `pose` in
/// `world`, a mission that drives to `goal`.
class PlanningGraph {
 public:
  PlanningGraph() {
    scan_pub_ = nh.advertise<sensor_msgs::LaserScan>("scan", 10);
    odometry_pub_ = nh.advertise<nav_msgs::Odometry>("odom", 10);
    state_pub_ = nh.advertise<MissionState>("mission/state", 10, true);
    goal_pub_ = nh.advertise<geometry_msgs::PoseStamped>("mission/goal", 1, true);
    geometry_msgs::TransformStamped laser;
    laser.header.frame_id = "base_link";
    laser.child_frame_id = "laser";
    laser.transform.rotation.w = 1.0;
    tf_.sendTransform(laser);
  }

  /// Waits until the node of that name hears everything.
  bool connect(const std::string& node) {
    return clock.waitForNode(node) && waitForSubscriber(scan_pub_) && waitForSubscriber(odometry_pub_) &&
           waitForSubscriber(state_pub_) && waitForSubscriber(goal_pub_);
  }

  void driveTo(const Pose2& goal) {
    geometry_msgs::PoseStamped msg;
    msg.header.stamp = clock.now();
    msg.header.frame_id = "odom";
    msg.pose = toRos(goal);
    goal_pub_.publish(msg);
    mission.mode = Mode::kLidar;
    mission.phase = MissionPhase::kDriving;
    ++mission.goal_number;
  }
  void stopMission() {
    mission.mode = Mode::kIdle;
    mission.phase = MissionPhase::kCancelled;
  }

  /// The scan at the present place and time.
  sensor_msgs::LaserScan scan() const {
    const LaserScan core = world.scan(pose);
    sensor_msgs::LaserScan msg;
    msg.header.stamp = clock.now();
    msg.header.frame_id = "laser";
    msg.angle_min = static_cast<float>(core.angle_min_rad);
    msg.angle_increment = static_cast<float>(core.angle_increment_rad);
    msg.angle_max = msg.angle_min + 359 * msg.angle_increment;
    msg.range_min = static_cast<float>(core.range_min_m);
    msg.range_max = static_cast<float>(core.range_max_m);
    msg.ranges = core.ranges_m;
    return msg;
  }
  void publishScan(const sensor_msgs::LaserScan& msg) { scan_pub_.publish(msg); }

  void publishOdometry() {
    Odometry odometry;
    odometry.stamp = toStamp(clock.now());
    odometry.odom_from_base = pose;
    odometry_pub_.publish(toRos(odometry, "odom", "base_link"));
  }
  void publishState() {
    mission.stamp = toStamp(clock.now());
    state_pub_.publish(toRos(mission));
  }

  /// A tenth of a second later: mission state and odometry of the new time.
  void beat() {
    clock.advance(0.1);
    publishState();
    publishOdometry();
  }

  ros::NodeHandle nh;
  TestClock clock{nh};
  planning_test::FlatWorld world = planning_test::FlatWorld().box(-1.0, -2.5, 6.0, 2.5);
  Pose2 pose;
  MissionStatus mission;

 private:
  ros::Publisher scan_pub_;
  ros::Publisher odometry_pub_;
  ros::Publisher state_pub_;
  ros::Publisher goal_pub_;
  tf2_ros::StaticTransformBroadcaster tf_;
};

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

}  // namespace frugal_nav::test
