#pragma once

#include <vector>

#include <frugal_nav/planning/moving_obstacles.hpp>
#include <frugal_nav/planning/rolling_grid.hpp>

namespace frugal_nav {

/// An obstacle of the active window.
struct WindowPoint {
  Eigen::Vector2d p_odom;  ///< where it was hit last [m]
  double certainty = 0.0;  ///< 0 .. 1
};

/// The rolling certainty grid close to the robot that the histogram methods decide on.
///
/// A cell also keeps where within it the last return lay, so that a passage is as wide as the scans say, not
/// as the cells do. What moves is kept beside the grid and leaves no trail in it. Where beams say nothing
/// (NaN) and nothing is known from before, something may stand: that is an obstacle too.
class ActiveWindow {
 public:
  explicit ActiveWindow(const RollingGridParams& params, const MovingObstaclesParams& moving = {});

  /// Takes a scan in and centres the window on the robot.
  void update(const LaserScan& scan, const Pose2& odom_from_laser, const Eigen::Vector2d& p_odom_robot);
  void reset();
  /// Other parameters from the next scan on; another window or cell size forgets everything. Throws
  /// ConfigError.
  void setParams(const RollingGridParams& params, const MovingObstaclesParams& moving = {});

  /// The obstacles within a distance of a place; of what moves and of what beams say nothing about, those of
  /// the last scan.
  std::vector<WindowPoint> pointsWithin(const Eigen::Vector2d& p_odom, double radius_m) const;

  const RollingGrid& grid() const { return grid_; }
  /// What moves, in odom.
  const MovingObstacles& moving() const { return moving_; }

 private:
  std::size_t placeOf(Cell cell) const;
  LaserScan takeMovingOut(const LaserScan& scan, const Pose2& odom_from_laser);
  void findUnseen(const LaserScan& scan, const Pose2& odom_from_laser);

  RollingGridParams params_;
  RollingGrid grid_;
  MovingObstacles moving_;
  std::vector<Eigen::Vector2d> moving_hits_;  ///< of the last scan, in odom
  std::vector<Eigen::Vector2d> unseen_;       ///< where it says nothing and nothing is known, in odom
  std::vector<Eigen::Vector2f> hits_;  ///< one a cell, in a ring as the grid's; valid where that is occupied
};

/// Where obstacles lie in base_link [m].
std::vector<Eigen::Vector2d> placesFrom(const Pose2& odom_from_base, const std::vector<WindowPoint>& points);

}  // namespace frugal_nav
