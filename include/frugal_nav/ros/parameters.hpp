#pragma once

#include <string>

#include <ros/node_handle.h>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav {

/// The parameters in a node handle's namespace; nested structs become "group/key".
/// Throws ConfigError on a value that is neither a truth value, a number, a text, nor a list of one of the
/// latter two.
ParamTree readParameterServer(const ros::NodeHandle& nh);

/// Fills a params struct from a node's private namespace; what is not set there keeps its default.
/// Throws ConfigError on an unknown key, a wrong type, or a value out of its range.
template <class Params>
void loadParameters(const ros::NodeHandle& pnh, Params& params) {
  assign(readParameterServer(pnh), pnh.getNamespace(), params);
}

/// The robot of the parameter `robot_description`, searched upward from the node's namespace; posed in its
/// link `base_frame`.
/// Throws ConfigError when it is not set or not a robot this package can drive.
RobotModel loadRobotDescription(const ros::NodeHandle& nh, const std::string& base_frame = "base_link");

}  // namespace frugal_nav
