#pragma once

#include <string>

#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/planning/lidar_avoidance.hpp>
#include <frugal_nav/planning/lidar_planner.hpp>
#include <frugal_nav/ros/intake_params.hpp>

namespace frugal_nav {

/// Parameters of the node planner: config/planner.yaml.
struct PlannerNodeParams {
  IntakeParams intake;
  ScanRules scan;
  LidarPlannerParams planner;
  double grid_period_s = 0.5;

  template <class Visitor>
  void fields(Visitor&& visit) {
    intake.fields(visit);
    visit("scan", scan);
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
