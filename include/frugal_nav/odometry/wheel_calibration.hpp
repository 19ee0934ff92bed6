#pragma once

#include <vector>

#include <Eigen/Core>

namespace frugal_nav {

/// Where the robot truly stood less where its odometry said it stood, at the end of squares that began along
/// +x in the frame of the start, one (x, y) a square [m].
struct SquareErrors {
  std::vector<Eigen::Vector2d> clockwise;
  std::vector<Eigen::Vector2d> counter_clockwise;
};

/// Factors on the radii and the separation that the odometry used.
struct WheelCalibration {
  double left_radius_multiplier = 1.0;
  double right_radius_multiplier = 1.0;
  double separation_multiplier = 1.0;
};

/// Systematic errors of a differential drive from squares driven both ways (UMBmark; Borenstein & Feng, IEEE
/// Trans. Robotics and Automation 12(6), 1996). Their mean scale cannot be seen in closed squares: the mean
/// radius is kept. Throws ConfigError on errors that are missing, not finite or too large for the method (a
/// turn off by 45 degrees), or on lengths that are not positive.
WheelCalibration calibrateWheels(const SquareErrors& errors, double side_m, double separation_m);

}  // namespace frugal_nav
