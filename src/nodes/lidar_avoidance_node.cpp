#include <frugal_nav/ros/lidar_avoidance_node.hpp>
#include <frugal_nav/ros/node_main.hpp>

int main(int argc, char** argv) {
  return frugal_nav::runNode<frugal_nav::LidarAvoidanceNode>(argc, argv, "lidar_avoidance");
}
