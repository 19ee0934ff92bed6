#pragma once

#include <optional>
#include <string>

#include <visualization_msgs/MarkerArray.h>

#include <frugal_nav/planning/camera_planner.hpp>

namespace frugal_nav {

/// The nodes of the instantaneous grid - robot, goal, nearest obstacle and gap - with the path through them,
/// and where what moves will be in the next two seconds. What is not there any more is taken away.
visualization_msgs::MarkerArray cameraPlanMarkers(const CameraPlan& plan,
                                                  const std::optional<Pose2>& odom_from_goal,
                                                  const std::string& odom_frame);

}  // namespace frugal_nav
