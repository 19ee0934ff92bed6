#pragma once

#include <Eigen/Core>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// Where the robot is in the odom frame, and how fast.
struct Odometry {
  Stamp stamp{};
  Pose2 odom_from_base;
  Twist2 twist;                                                ///< in base_link
  Eigen::Matrix3d pose_covariance = Eigen::Matrix3d::Zero();   ///< of (x, y, yaw)
  Eigen::Matrix2d twist_covariance = Eigen::Matrix2d::Zero();  ///< of (v, w)
};

}  // namespace frugal_nav
