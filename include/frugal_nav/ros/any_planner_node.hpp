#pragma once

#include <memory>

#include <frugal_nav/ros/camera_planner_node.hpp>
#include <frugal_nav/ros/planner_node.hpp>

namespace frugal_nav {

/// The node planner: in mode lidar or camera, as its parameter `mode` says.
class AnyPlannerNode {
 public:
  AnyPlannerNode(ros::NodeHandle nh, ros::NodeHandle pnh) {
    // Anything but "camera" is for the other mode's parameters to accept or refuse.
    if (pnh.param<std::string>("mode", "lidar") == "camera") {
      camera_ = std::make_unique<CameraPlannerNode>(nh, pnh);
    } else {
      lidar_ = std::make_unique<PlannerNode>(nh, pnh);
    }
  }

 private:
  std::unique_ptr<PlannerNode> lidar_;
  std::unique_ptr<CameraPlannerNode> camera_;
};

}  // namespace frugal_nav
