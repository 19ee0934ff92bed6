#pragma once

#include <cstdint>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/planning/obstacle_tracker.hpp>
#include <frugal_nav/planning/rolling_grid.hpp>

namespace frugal_nav {

struct MovingObstaclesParams {
  double standing_s = 2.0;
  double near_m = 0.12;
  double near_share = 0.015;
  double gap_m = 0.50;
  double margin_m = 0.15;
  ObstacleTrackerParams tracker = scannerTracker();

  /// What a planar scanner sees better than a camera, and what of a walker: one leg or both.
  static ObstacleTrackerParams scannerTracker();

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("standing_s", standing_s,
          Field{"s", "what has been in one place this long stands: longer than a foot in a slow walk", 0.1,
                60.0});
    visit("near_m", near_m,
          Field{"m", "a return this near to what stands is part of it: cells, odometry's drift", 0.0, 1.0});
    visit("near_share", near_share, Field{"", "and this share of its range more: noise", 0.0, 0.5});
    visit("gap_m", gap_m, Field{"m", "returns this near to each other are one object: two legs", 0.0, 2.0});
    visit("margin_m", margin_m,
          Field{"m", "returns this much beyond a moving object's radius are its own", 0.0, 1.0});
    visit("tracker", tracker);
  }
};

/// What moves in a planar scanner's view: returns from places that were seen free before, followed from scan
/// to scan.
///
/// A place that was never seen is taken to be standing, and so is what has stood for a while.
class MovingObstacles {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit MovingObstacles(const MovingObstaclesParams& params);

  /// Takes a scan in. `grid` is what was known before it, its window already about the robot.
  void update(const LaserScan& scan, const Pose2& odom_from_laser, const RollingGrid& grid);
  void reset();

  /// Those that move now, in odom.
  const std::vector<TrackedObstacle>& moving() const { return moving_; }
  /// The last scan's returns from places that were free before, in odom: of what moves, or came just now.
  const std::vector<Eigen::Vector2d>& newcomers() const { return newcomers_; }
  /// Whether a return belongs to one that moves.
  bool isMoving(const Eigen::Vector2d& p_odom) const;
  /// Whether a return belongs to one that moves away from a place.
  bool isLeaving(const Eigen::Vector2d& p_odom, const Eigen::Vector2d& from_odom) const;

 private:
  bool stands(std::size_t place) const;
  void remember(const LaserScan& scan, const Pose2& odom_from_laser, const RollingGrid& grid);
  bool isNew(const Eigen::Vector2d& p_odom, double range_m, const RollingGrid& grid) const;
  LaserScan newReturns(const LaserScan& scan, const Pose2& odom_from_laser, const RollingGrid& grid);

  MovingObstaclesParams params_;
  ObstacleTracker tracker_;
  std::vector<TrackedObstacle> moving_;
  std::vector<Eigen::Vector2d> newcomers_;
  Stamp now_{};
  std::vector<Stamp> since_;  ///< a cell has been occupied without a break, in a ring as the grid's
  std::vector<Stamp> stood_;  ///< when it was last hit and had stood, likewise
};

}  // namespace frugal_nav
