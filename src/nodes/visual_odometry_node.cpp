#include <frugal_nav/ros/node_main.hpp>
#include <frugal_nav/ros/visual_odometry_node.hpp>

int main(int argc, char** argv) {
  return frugal_nav::runNode<frugal_nav::VisualOdometryNode>(argc, argv, "visual_odometry");
}
