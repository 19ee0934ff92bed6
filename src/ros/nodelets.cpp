#include <pluginlib/class_list_macros.hpp>

#include <frugal_nav/ros/any_planner_node.hpp>
#include <frugal_nav/ros/base_controller_node.hpp>
#include <frugal_nav/ros/lidar_avoidance_node.hpp>
#include <frugal_nav/ros/mission_node.hpp>
#include <frugal_nav/ros/node_main.hpp>
#include <frugal_nav/ros/wheel_odometry_node.hpp>

// Every node class is a nodelet too: PLUGINLIB_EXPORT_CLASS(frugal_nav::NodeletOf<frugal_nav::FooNode>,
// nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(frugal_nav::BaseControllerNodelet, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(frugal_nav::NodeletOf<frugal_nav::WheelOdometryNode>, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(frugal_nav::NodeletOf<frugal_nav::LidarAvoidanceNode>, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(frugal_nav::NodeletOf<frugal_nav::AnyPlannerNode>, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(frugal_nav::NodeletOf<frugal_nav::MissionNode>, nodelet::Nodelet)
