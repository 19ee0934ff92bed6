#include <ros/ros.h>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/ros/simulator_node.hpp>

int main(int argc, char** argv) {
  ros::init(argc, argv, "simulator");
  try {
    frugal_nav::SimulatorNode node(ros::NodeHandle(), ros::NodeHandle("~"));
    node.run();
  } catch (const frugal_nav::ConfigError& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
