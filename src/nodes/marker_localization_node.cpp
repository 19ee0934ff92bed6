#include <frugal_nav/ros/marker_localization_node.hpp>
#include <frugal_nav/ros/node_main.hpp>

int main(int argc, char** argv) {
  return frugal_nav::runNode<frugal_nav::MarkerLocalizationNode>(argc, argv, "marker_localization");
}
