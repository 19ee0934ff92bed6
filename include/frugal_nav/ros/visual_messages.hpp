#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/PointCloud2.h>

#include <frugal_nav/Obstacle.h>
#include <frugal_nav/VoStatus.h>
#include <frugal_nav/odometry/visual_obstacle.hpp>
#include <frugal_nav/odometry/visual_odometry.hpp>

namespace frugal_nav {

/// A pose in space as a message.
geometry_msgs::Pose toRos(const Eigen::Isometry3d& pose);

/// How visual odometry fares, in words too.
VoStatus toRos(const VisualStatus& status, Stamp stamp, const std::string& frame);

/// The pose with its covariance, and the velocity in the body since the output before, when there is one.
nav_msgs::Odometry toRos(const VisualOdometryOutput& output, const VisualOdometryOutput* before,
                         const std::string& odom_frame, const std::string& base_frame);

/// Points x, y, z [m] with their pixel u, v and the standard deviation of their depth sigma [m], all float32.
/// `odom_from_camera` places them. Empty while they are not in metres.
sensor_msgs::PointCloud2 pointsMessage(const VisualOdometryOutput& output,
                                       const Eigen::Isometry3d& odom_from_camera,
                                       const std::string& odom_frame);

/// Points x, y, z [m], float32.
sensor_msgs::PointCloud2 cloudMessage(const std::vector<Eigen::Vector3f>& points, Stamp stamp,
                                      const std::string& frame);

/// The obstacle as the points show it, or why there is none. `odom_from_visual` takes visual odometry's
/// places to those of the odometry in use.
Obstacle toRos(const VisualObstacleResult& result, const Eigen::Isometry3d& odom_from_visual,
               const cv::Rect& region, Stamp stamp, const std::string& odom_frame);

}  // namespace frugal_nav
