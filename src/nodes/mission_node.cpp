#include <frugal_nav/ros/mission_node.hpp>
#include <frugal_nav/ros/node_main.hpp>

int main(int argc, char** argv) {
  return frugal_nav::runNode<frugal_nav::MissionNode>(argc, argv, "mission");
}
