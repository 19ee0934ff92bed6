#include <pluginlib/class_list_macros.hpp>

#include <frugal_nav/ros/node_main.hpp>

// Every node class is a nodelet too: PLUGINLIB_EXPORT_CLASS(frugal_nav::NodeletOf<frugal_nav::FooNode>,
// nodelet::Nodelet)
