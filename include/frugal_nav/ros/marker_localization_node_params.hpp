#pragma once

#include <string>

#include <frugal_nav/localization/marker_localization_params.hpp>
#include <frugal_nav/ros/intake_params.hpp>

namespace frugal_nav {

/// Parameters of the node marker_localization: config/marker_localization.yaml. This header needs no ROS.
struct MarkerLocalizationNodeParams {
  ImageIntakeParams intake;
  std::string marker_map;
  bool publish_tf = true;
  bool use_markers = true;
  bool use_odometry = true;
  bool use_imu = true;
  double set_pose_sigma_m = 0.2;
  double set_pose_sigma_rad = 0.2;
  MarkerLocalizationParams localization;

  template <class Visitor>
  void fields(Visitor&& visit) {
    intake.fields(visit);
    visit(
        "marker_map", marker_map,
        atStart(Field{"", "file of the markers' places, its absolute path; check_marker_map looks it over"}));
    visit("publish_tf", publish_tf,
          atStart(Field{"", "broadcast the map's frame -> odom_frame; false when another filter owns it"}));
    visit("use_markers", use_markers,
          atStart(
              Field{"", "whether markers count from the start on; the service ~use_markers switches them"}));
    visit("use_odometry", use_odometry, atStart(Field{"", "the same of the twist: service ~use_odometry"}));
    visit("use_imu", use_imu, atStart(Field{"", "the same of the IMU's yaw rate: service ~use_imu"}));
    visit("set_pose_sigma_m", set_pose_sigma_m,
          Field{"m", "standard deviation of a pose on set_pose that brings no covariance: placed by hand",
                0.001, 100.0});
    visit("set_pose_sigma_rad", set_pose_sigma_rad, Field{"rad", "the same of its heading", 0.001, 3.2});
    localization.fields(visit);
  }
};

}  // namespace frugal_nav
