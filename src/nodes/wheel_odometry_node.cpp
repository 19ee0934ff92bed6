#include <frugal_nav/ros/node_main.hpp>
#include <frugal_nav/ros/wheel_odometry_node.hpp>

int main(int argc, char** argv) {
  return frugal_nav::runNode<frugal_nav::WheelOdometryNode>(argc, argv, "wheel_odometry");
}
