#pragma once

#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/nearest_obstacle.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/planning/obstacle_tracker.hpp>
#include <frugal_nav/planning/rolling_grid.hpp>

namespace frugal_nav {

struct ObstacleMemoryParams {
  RollingGridParams grid{10.0, 0.05, 2, 1, 16, 30.0, 3.5};
  ObstacleTrackerParams tracker;
  int standing_certainty = 12;
  double sigma_m = 0.03;
  double sigma_share = 0.03;
  double largest_sigma_m = 0.25;
  double clear_from_m = 1.2;
  double clear_doubtful_from_m = 0.75;
  double near_share = 0.35;
  double near_beyond_m = 0.6;
  double person_radius_m = 0.40;
  double person_range_share = 0.10;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("grid", grid);
    visit("tracker", tracker);
    visit(
        "standing_certainty", standing_certainty,
        Field{
            "",
            "a place more certain than this holds something that stands: nothing seen there moves, and what "
            "walks by does not wipe it out; above what a slow walker leaves before it is known to move",
            0, 120});
    visit("sigma_m", sigma_m,
          Field{"m", "noise of a range: what lies this near before a hit is not taken for free", 0.0, 1.0});
    visit("sigma_share", sigma_share, Field{"", "the same, as a share of the range", 0.0, 1.0});
    visit("largest_sigma_m", largest_sigma_m,
          Field{"m", "the nearest obstacle is not blown up by more than this", 0.0, 2.0});
    visit("clear_from_m", clear_from_m,
          Field{"m",
                "nearer than this no ray takes an obstacle away: the floor is below the image there, and "
                "what has "
                "left the view below is remembered",
                0.0, 5.0});
    visit("clear_doubtful_from_m", clear_doubtful_from_m,
          Field{"m",
                "but from here on it takes away what is no more certain than standing_certainty: only low "
                "things are below the image there",
                0.0, 5.0});
    visit("near_share", near_share,
          Field{"",
                "a hit within clear_from_m, where no foot is in view, is a guess: unless right on a "
                "remembered obstacle it marks nothing where its ray holds one, nearer by at most this share",
                0.0, 1.0});
    visit("near_beyond_m", near_beyond_m, Field{"m", "or farther by at most this", 0.0, 3.0});
    visit("person_radius_m", person_radius_m,
          Field{"m", "hits this near to the person who is the goal are the person's", 0.0, 2.0});
    visit("person_range_share", person_range_share,
          Field{"",
                "and along the line of sight that much of the distance more: a person's distance is known "
                "worse than its bearing",
                0.0, 1.0});
  }
};

/// What the camera has seen in the last seconds, in odom: standing things in a rolling grid, moving ones
/// beside it with where they go.
///
/// Depth along a ray is what a camera knows worst: a ray clears only up to a standard deviation before its
/// hit, and the nearest obstacle, which brings its own sigma, is marked that much larger.
class ObstacleMemory {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit ObstacleMemory(const ObstacleMemoryParams& params);
  /// Other parameters from the next image on; another window or cell size forgets. Throws ConfigError.
  void setParams(const ObstacleMemoryParams& params);

  /// Takes in what one image shows: a sound scan in base_link, the nearest obstacle, and the person who is
  /// the goal and no obstacle, if there is one.
  void insert(const LaserScan& scan, const NearestObstacle& obstacle, const Pose2& odom_from_base,
              const std::optional<Eigen::Vector2d>& p_odom_person);
  /// Forgets everything.
  void reset();

  /// The standing things.
  const RollingGrid& grid() const { return grid_; }
  /// The moving ones as of the last insert().
  const std::vector<TrackedObstacle>& moving() const { return moving_; }

 private:
  bool isPerson(const Eigen::Vector2d& p_odom, const Eigen::Vector2d& robot,
                const std::optional<Eigen::Vector2d>& p_odom_person) const;
  bool isMoving(const Eigen::Vector2d& p_odom) const;
  bool isStanding(const Eigen::Vector2d& p_odom) const;
  void follow(const LaserScan& scan, const NearestObstacle& obstacle, const Pose2& odom_from_base,
              const std::optional<Eigen::Vector2d>& p_odom_person);
  std::vector<double> clearLengths(const LaserScan& scan, double longest_m) const;
  bool isKnown(const Eigen::Vector2d& robot, const Eigen::Vector2d& p_odom) const;
  void markNearest(const NearestObstacle& obstacle);

  ObstacleMemoryParams params_;
  RollingGrid grid_;
  ObstacleTracker tracker_;
  std::vector<TrackedObstacle> moving_;
};

}  // namespace frugal_nav
