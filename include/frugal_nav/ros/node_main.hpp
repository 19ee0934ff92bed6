#pragma once

#include <memory>
#include <string>

#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// The whole main() of a standalone node. A bad configuration is one FATAL line and exit code 1.
template <class Node>
int runNode(int argc, char** argv, const std::string& name) {
  ros::init(argc, argv, name);
  const ros::NodeHandle keeps_logging;  // with the last handle ROS shuts down, its log too
  try {
    Node node{ros::NodeHandle(), ros::NodeHandle("~")};
    ros::spin();
  } catch (const ConfigError& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}

/// A node of a nodelet. Where its configuration is wrong the reason is told before the manager, which only
/// says that the nodelet did not load.
template <class Node>
std::unique_ptr<Node> makeNode(const ros::NodeHandle& nh, const ros::NodeHandle& pnh) {
  try {
    return std::make_unique<Node>(nh, pnh);
  } catch (const ConfigError& error) {
    ROS_FATAL("%s: %s", pnh.getNamespace().c_str(), error.what());
    throw;
  }
}

/// The same node class as a nodelet. Its callbacks run on the single-threaded queue, so the class needs no
/// lock.
template <class Node>
class NodeletOf : public nodelet::Nodelet {
 private:
  void onInit() override { node_ = makeNode<Node>(getNodeHandle(), getPrivateNodeHandle()); }

  std::unique_ptr<Node> node_;
};

}  // namespace frugal_nav
