#include <pluginlib/class_list_macros.hpp>

#include <frugal_nav/ros/depth_gap_node.hpp>
#include <frugal_nav/ros/goal_detector_node.hpp>
#include <frugal_nav/ros/marker_localization_node.hpp>
#include <frugal_nav/ros/node_main.hpp>
#include <frugal_nav/ros/visual_odometry_node.hpp>

// The node classes that take images, as nodelets: in one manager their images pass without a copy.
PLUGINLIB_EXPORT_CLASS(frugal_nav::NodeletOf<frugal_nav::DepthGapNode>, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(frugal_nav::NodeletOf<frugal_nav::GoalDetectorNode>, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(frugal_nav::NodeletOf<frugal_nav::MarkerLocalizationNode>, nodelet::Nodelet)
PLUGINLIB_EXPORT_CLASS(frugal_nav::NodeletOf<frugal_nav::VisualOdometryNode>, nodelet::Nodelet)
