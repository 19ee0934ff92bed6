#pragma once

#include <frugal_nav/odometry/visual_obstacle.hpp>
#include <frugal_nav/odometry/visual_params.hpp>
#include <frugal_nav/ros/intake_params.hpp>

namespace frugal_nav {

/// The accumulated cloud vo/map.
struct VisualMapOutputParams {
  double voxel_m = 0.05;
  int max_points = 200000;
  double period_s = 1.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("voxel_m", voxel_m, Field{"m", "side of the cubes that keep one mean point each", 0.005, 1.0});
    visit("max_points", max_points,
          Field{"", "points kept: 200000 are 3 MB, a building's floor", 100, 10000000});
    visit("period_s", period_s,
          Field{"s", "time between two publications, only while someone listens", 0.05, 60.0});
  }
};

/// Parameters of the node visual_odometry: config/visual_odometry.yaml. This header needs no ROS.
struct VisualOdometryNodeParams {
  ImageIntakeParams intake;
  bool publish_tf = false;
  bool use_region = true;
  double region_age_s = 1.0;
  VisualOdometryParams odometry;
  VisualObstacleParams obstacle;
  VisualMapOutputParams map_output;

  template <class Visitor>
  void fields(Visitor&& visit) {
    intake.fields(visit);
    visit("publish_tf", publish_tf,
          atStart(Field{"",
                        "broadcast vo/odom as odom_frame -> base_frame; only where nobody else does: with it "
                        "set wheel_odometry's publish_tf false"}));
    visit("use_region", use_region,
          atStart(Field{"", "whether the region of obstacle/nearest is searched for more features"}));
    visit("region_age_s", region_age_s,
          Field{"s", "an older region is of no use: the robot has moved on", 0.05, 10.0});
    odometry.fields(visit);
    visit("obstacle", obstacle);
    visit("map_output", map_output);
  }
};

}  // namespace frugal_nav
