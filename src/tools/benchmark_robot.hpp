#pragma once

#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav {

/// A box on wheels of frugal_bot's size: the program reads no files.
inline RobotModel boxRobot() {
  RobotModel robot;
  robot.name = "box";
  robot.drive = {"left", "right", 0.21, 0.033};
  robot.footprint = {{-0.16, -0.125}, {0.12, -0.125}, {0.12, 0.125}, {-0.16, 0.125}};
  Eigen::Isometry3d middle = Eigen::Isometry3d::Identity();
  middle.translation() = Eigen::Vector3d(-0.02, 0.0, 0.105);
  robot.collisions.push_back({"base_link", BoxShape{{0.28, 0.25, 0.05}}, middle, {}});
  robot.base_from_link["laser"] = Eigen::Isometry3d(Eigen::Translation3d(0.02, 0.0, 0.18));
  robot.base_from_link["imu_link"] = Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 0.06));
  Eigen::Isometry3d camera(Eigen::Translation3d(-0.12, 0.0, 0.4));
  camera.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  robot.base_from_link["camera_optical_frame"] = camera;
  return robot;
}

}  // namespace frugal_nav
