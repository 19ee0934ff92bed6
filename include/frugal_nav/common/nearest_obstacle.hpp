#pragma once

#include <limits>
#include <string>

#include <Eigen/Core>

#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// The nearest obstacle in view of the camera. The message Obstacle carries it.
struct NearestObstacle {
  Stamp stamp{};       ///< of the image
  bool found = false;  ///< false: there is none, or the image is of no use; `reason` says which
  std::string reason;
  Eigen::Vector2d p_odom = Eigen::Vector2d::Zero();  ///< the nearest place of its surface, on the floor
  double distance_m = std::numeric_limits<double>::quiet_NaN();  ///< from base_link to that place
  double bearing_rad = 0.0;                                      ///< in base_link, left positive
  double sigma_m = std::numeric_limits<double>::quiet_NaN();     ///< standard deviation of the distance
  std::string source;  ///< the cue it rests on most: "vo", "floor", "goal", "network"
  Eigen::Vector2d velocity_mps = Eigen::Vector2d::Zero();  ///< in odom; zero for what stands
  int left_px = 0;                                         ///< its region in the image as given
  int top_px = 0;
  int width_px = 0;
  int height_px = 0;
};

}  // namespace frugal_nav
