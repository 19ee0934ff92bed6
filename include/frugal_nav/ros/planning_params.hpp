#pragma once

#include <string>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/planning/lidar_avoidance.hpp>
#include <frugal_nav/planning/lidar_planner.hpp>

namespace frugal_nav {

/// What planner and lidar_avoidance share. This header needs no ROS.
struct ScanIntakeParams {
  std::string odom_frame = "odom";
  std::string base_frame = "base_link";
  double odom_wait_s = 0.25;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("odom_frame", odom_frame, Field{"", "frame of odometry, goal and path"});
    visit("base_frame", base_frame, Field{"", "frame of the body, in which tf gives the laser's pose"});
    visit("odom_wait_s", odom_wait_s,
          Field{"s", "ROS time a scan waits for odometry of its stamp before it is given up", 0.01, 5.0});
  }
};

/// Parameters of the node planner: config/planner.yaml.
struct PlannerNodeParams {
  ScanIntakeParams intake;
  LidarPlannerParams planner;
  double grid_period_s = 0.5;

  template <class Visitor>
  void fields(Visitor&& visit) {
    intake.fields(visit);
    visit("grid_period_s", grid_period_s,
          Field{"s", "time between two publications of the grid, only while someone listens", 0.05, 60.0});
    planner.fields(visit);
  }
};

/// Parameters of the node lidar_avoidance: config/lidar_avoidance.yaml.
struct LidarAvoidanceNodeParams {
  ScanIntakeParams intake;
  LidarAvoidanceParams avoidance;

  template <class Visitor>
  void fields(Visitor&& visit) {
    intake.fields(visit);
    avoidance.fields(visit);
  }
  std::string check() const { return avoidance.check(); }
};

}  // namespace frugal_nav
