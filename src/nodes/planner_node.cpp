#include <frugal_nav/ros/any_planner_node.hpp>
#include <frugal_nav/ros/node_main.hpp>

int main(int argc, char** argv) {
  return frugal_nav::runNode<frugal_nav::AnyPlannerNode>(argc, argv, "planner");
}
