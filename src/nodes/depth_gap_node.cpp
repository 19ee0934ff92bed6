#include <frugal_nav/ros/depth_gap_node.hpp>
#include <frugal_nav/ros/node_main.hpp>

int main(int argc, char** argv) {
  return frugal_nav::runNode<frugal_nav::DepthGapNode>(argc, argv, "depth_gap");
}
