#pragma once

#include <optional>
#include <string>

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/time.h>
#include <sensor_msgs/LaserScan.h>

#include <frugal_nav/Gap.h>
#include <frugal_nav/LocalCommand.h>
#include <frugal_nav/MissionState.h>
#include <frugal_nav/Obstacle.h>
#include <frugal_nav/common/gap_sighting.hpp>
#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/mission_status.hpp>
#include <frugal_nav/common/motion_command.hpp>
#include <frugal_nav/common/nearest_obstacle.hpp>
#include <frugal_nav/common/odometry.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

Stamp toStamp(const ros::Time& time);
ros::Time toRos(Stamp stamp);

geometry_msgs::Pose toRos(const Pose2& pose);
geometry_msgs::Twist toRos(const Twist2& twist);
/// A pose on the floor with its covariance of (x, y, yaw); z, roll and pitch are zero, as sure as a filter
/// that takes it likes.
geometry_msgs::PoseWithCovariance toRos(const Pose2& pose, const Eigen::Matrix3d& covariance);
/// The covariance of (x, y, yaw).
Eigen::Matrix3d planarCovariance(const geometry_msgs::PoseWithCovariance& pose);

/// Yaw of a quaternion; nullopt when it is not finite or its length is not within 0.01 of 1.
std::optional<double> yawOf(const geometry_msgs::Quaternion& q);
/// The planar part of a pose; nullopt when it is not finite or its quaternion is none.
std::optional<Pose2> planar(const geometry_msgs::Pose& pose);
/// The planar part of a twist as it stands, finite or not: the receiver refuses and counts bad ones.
Twist2 planar(const geometry_msgs::Twist& twist);

LaserScan fromRos(const sensor_msgs::LaserScan& msg);
/// Why a scan's angles contradict each other: with a wrong increment it shows everything elsewhere. Up to two
/// beams and five per cent are let pass, as drivers that count their beams anew in each turn need.
std::optional<std::string> findAngleFault(const sensor_msgs::LaserScan& msg);
sensor_msgs::LaserScan toRos(const LaserScan& scan, const std::string& frame);

/// nullopt when the pose is not finite or its quaternion is none.
std::optional<Odometry> fromRos(const nav_msgs::Odometry& msg);
nav_msgs::Odometry toRos(const Odometry& odometry, const std::string& odom_frame,
                         const std::string& base_frame);

/// A path in the frame of its header; nullopt when a pose is not finite or has no sound quaternion.
std::optional<Path2> fromRos(const nav_msgs::Path& msg);
nav_msgs::Path toRos(const Path2& path, Stamp stamp, const std::string& frame);

/// nullopt when the status is unknown, or what the command holds is not finite.
std::optional<MotionCommand> fromRos(const LocalCommand& msg);
LocalCommand toRos(const MotionCommand& command, const std::string& odom_frame);

/// nullopt when mode or state is none of the message's constants.
std::optional<MissionStatus> fromRos(const MissionState& msg);
MissionState toRos(const MissionStatus& status);

/// nullopt when a gap was found and its node or a bearing is not finite; width and depth may be NaN.
std::optional<GapSighting> fromRos(const Gap& msg);
Gap toRos(const GapSighting& gap, const std::string& odom_frame);

/// nullopt when an obstacle was found and its place, velocity or distance is not finite.
std::optional<NearestObstacle> fromRos(const Obstacle& msg);
Obstacle toRos(const NearestObstacle& obstacle, const std::string& odom_frame);

}  // namespace frugal_nav
