#pragma once

#include <string>

#include <nav_msgs/OccupancyGrid.h>
#include <visualization_msgs/MarkerArray.h>

#include <frugal_nav/common/motion_command.hpp>
#include <frugal_nav/control/base_control.hpp>
#include <frugal_nav/planning/lidar_planner.hpp>
#include <frugal_nav/planning/sector_avoidance.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav {

/// What planning has to know of a robot.
BodyExtent extentOf(const RobotModel& robot);

/// The rolling grid: 100 obstacle, 0 free, -1 unknown.
nav_msgs::OccupancyGrid gridMessage(const RollingGrid& grid, ros::Time stamp, const std::string& odom_frame);

/// The path as a ribbon and its goal as a ring around the tolerance; without a path both are taken away.
visualization_msgs::MarkerArray planMarkers(const LidarPlan& plan, const std::optional<Pose2>& odom_from_goal,
                                            double goal_tolerance_m, const std::string& odom_frame);

/// The sectors as a coloured ring around the robot (green free, red blocked, blue chosen) and the target.
visualization_msgs::MarkerArray sectorMarkers(const SectorAvoidance::Decision& decision,
                                              const MotionCommand& command, const std::string& base_frame,
                                              const std::string& odom_frame);

/// The footprint in the colour of what the safety barrier leaves of the command, with the reason beside it:
/// green drives, orange slowed or turned aside by it, red stands for a fault or an obstacle, grey has no
/// goal.
visualization_msgs::MarkerArray barrierMarkers(const BaseCommand& command, Stamp stamp,
                                               const Polygon2& footprint, const std::string& base_frame);

}  // namespace frugal_nav
