#include <frugal_nav/ros/goal_detector_node.hpp>
#include <frugal_nav/ros/node_main.hpp>

int main(int argc, char** argv) {
  return frugal_nav::runNode<frugal_nav::GoalDetectorNode>(argc, argv, "goal_detector");
}
