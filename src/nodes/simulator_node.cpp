#include <ros/ros.h>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/ros/simulator_node.hpp>

int main(int argc, char** argv) {
  ros::init(argc, argv, "simulator");
  // Outside the try block: with the last handle gone roscpp shuts down, and the message below would be lost.
  const ros::NodeHandle nh;
  const ros::NodeHandle pnh("~");
  try {
    frugal_nav::SimulatorNode node(nh, pnh);
    node.run();
  } catch (const frugal_nav::ConfigError& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
