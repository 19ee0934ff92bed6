#pragma once

#include <cmath>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/motion_command.hpp>
#include <frugal_nav/common/odometry.hpp>
#include <frugal_nav/planning/active_window.hpp>

namespace frugal_nav {

/// What a local planner decides on; all of one instant, the scan's.
struct LocalPlannerInput {
  const LaserScan& scan;  ///< sound: findFault() found nothing
  Pose2 base_from_laser;
  const std::vector<Eigen::Vector2d>& obstacles_base;  ///< the scan's obstaclePoints() [m]
  Odometry odometry;                                   ///< pose and twist at the scan's stamp
  Eigen::Vector2d target_odom;                         ///< where to go next: on the path, or the goal itself
  Eigen::Vector2d goal_odom;                           ///< where it all leads
  const ActiveWindow* window = nullptr;  ///< what the last scans said; the sector method needs none
  double way_m = HUGE_VAL;               ///< how far it may drive now
};

/// Bearing of the larger clearance that the scan shows, in base_link; of equal ones the nearest to the
/// target.
double clearBearing(const LocalPlannerInput& input);

/// A method of avoiding obstacles on the way to a near target.
class LocalPlanner {
 public:
  virtual ~LocalPlanner() = default;

  /// The command for one scan; its stamp is the scan's and clear_bearing_rad is always filled.
  virtual MotionCommand plan(const LocalPlannerInput& input) = 0;

  /// Forgets what earlier scans led to: after a new goal or a jump in time.
  virtual void reset() = 0;
};

}  // namespace frugal_nav
