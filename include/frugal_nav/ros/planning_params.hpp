#pragma once

#include <string>

#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/planning/camera_planner.hpp>
#include <frugal_nav/planning/lidar_avoidance.hpp>
#include <frugal_nav/planning/lidar_planner.hpp>
#include <frugal_nav/ros/intake_params.hpp>

namespace frugal_nav {

/// What the planner plans from; said in the parameters of both its modes.
struct PlannerMode {
  std::string value;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("mode", value,
          atStart(Field{"", "what it plans from: scan, or gap, obstacle/nearest and depth/scan", -HUGE_VAL,
                        HUGE_VAL, "lidar|camera"}));
  }
};

/// Parameters of the node planner in mode lidar: config/planner.yaml.
struct PlannerNodeParams {
  PlannerMode mode{"lidar"};
  IntakeParams intake;
  ScanRules scan;
  LidarPlannerParams planner;
  double grid_period_s = 0.5;

  template <class Visitor>
  void fields(Visitor&& visit) {
    mode.fields(visit);
    intake.fields(visit);
    visit("scan", scan);
    visit("grid_period_s", grid_period_s,
          Field{"s", "time between two publications of the grid, only while someone listens", 0.05, 60.0});
    planner.fields(visit);
  }
};

/// Parameters of the node planner in mode camera: config/camera_planner.yaml.
struct CameraPlannerNodeParams {
  PlannerMode mode{"camera"};
  IntakeParams intake;
  double input_wait_s = 0.3;
  double person_near_goal_m = 1.3;
  double person_memory_s = 60.0;
  double grid_period_s = 0.5;
  CameraPlannerParams planner;

  template <class Visitor>
  void fields(Visitor&& visit) {
    mode.fields(visit);
    intake.fields(visit);
    visit("input_wait_s", input_wait_s,
          atStart(Field{"s",
                        "ROS time the first of an image's gap, obstacle/nearest and depth/scan waits for the "
                        "others",
                        0.01, 10.0}));
    visit(
        "person_near_goal_m", person_near_goal_m,
        Field{
            "m",
            "a person on goal/observed this near to mission/goal is the goal: kept off by a person's radius, "
            "but no obstacle; above the mission's stand-off of 0.8 m",
            0.0, 10.0});
    visit("person_memory_s", person_memory_s,
          Field{"s", "for how long after the last word of goal/observed", 0.0, 36000.0});
    visit("grid_period_s", grid_period_s,
          Field{"s", "time between two publications of the grid, only while someone listens", 0.05, 60.0});
    planner.fields(visit);
  }
};

/// Parameters of the node lidar_avoidance: config/lidar_avoidance.yaml.
struct LidarAvoidanceNodeParams {
  IntakeParams intake;
  ScanRules scan;
  LidarAvoidanceParams avoidance;

  template <class Visitor>
  void fields(Visitor&& visit) {
    intake.fields(visit);
    visit("scan", scan);
    avoidance.fields(visit);
  }
  std::string check() const { return avoidance.check(); }
};

}  // namespace frugal_nav
