#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

struct ObstacleTrackerParams {
  double max_range_m = 3.5;
  double smallest_m = 0.15;
  double largest_m = 0.9;
  double jump_m = 0.35;
  double sigma_m = 0.06;
  double range_sigma_share = 0.06;
  double bearing_sigma_rad = 0.03;
  double near_m = 1.2;
  double near_sigma_share = 0.15;
  double start_speed_mps = 0.6;
  double acceleration_mps2 = 0.25;
  double fastest_mps = 1.3;
  double slowest_mps = 0.18;
  double significance = 2.5;
  int least_sightings = 4;
  double least_way_m = 0.25;
  double largest_misfit = 2.0;
  double out_of_view_s = 2.5;
  double unseen_s = 0.9;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("max_range_m", max_range_m, Field{"m", "objects farther away are not followed", 0.5, 20.0});
    visit("smallest_m", smallest_m,
          Field{"m", "narrower things do not move by themselves: legs of furniture, noise of the depth", 0.0,
                1.0});
    visit("largest_m", largest_m, Field{"m", "wider things are furniture and walls, not people", 0.1, 5.0});
    visit("jump_m", jump_m,
          Field{"m", "step in range that separates an object from what lies behind", 0.05, 2.0});
    visit("sigma_m", sigma_m, Field{"m", "noise of an object's place: swinging limbs", 0.0, 1.0});
    visit("range_sigma_share", range_sigma_share,
          Field{"", "noise of its distance, as a share: error of the depth scale", 0.0, 1.0});
    visit("bearing_sigma_rad", bearing_sigma_rad, Field{"rad", "noise of its bearing: one column", 0.0, 1.0});
    visit("near_m", near_m,
          Field{"m", "nearer than this a place is a guess, since a camera sees no foot there; 0: never", 0.0,
                5.0});
    visit("near_sigma_share", near_sigma_share,
          Field{"", "noise of a guessed place, as a share of its distance", 0.0, 1.0});
    visit("start_speed_mps", start_speed_mps,
          Field{"m/s", "standard deviation of a new object's speed: a walking person", 0.05, 5.0});
    visit("acceleration_mps2", acceleration_mps2,
          Field{"m/s^2", "how fast a person changes its velocity", 0.01, 10.0});
    visit("fastest_mps", fastest_mps, Field{"m/s", "faster is another object", 0.2, 10.0});
    visit("slowest_mps", slowest_mps,
          Field{"m/s", "slower stands: the visible side of a box wanders while the robot passes it", 0.01,
                2.0});
    visit("significance", significance,
          Field{"", "standard deviations by which its velocity must differ from zero", 0.5, 10.0});
    visit("least_sightings", least_sightings, Field{"", "sightings before a velocity counts", 2, 20});
    visit("least_way_m", least_way_m,
          Field{"m",
                "and the way it has come, which must also take it off the place it was seen first: what "
                "stands wanders by the depth's error, and by its own size as more of it comes into view",
                0.0, 5.0});
    visit("largest_misfit", largest_misfit,
          Field{"",
                "and its sightings must lie on its way: mean of their squared distances from where it was "
                "expected, in standard deviations, 2 where the noise is as said; several things taken for "
                "one do worse",
                0.1, 100.0});
    visit("out_of_view_s", out_of_view_s,
          Field{"s", "one that walked out of view is believed to go on for this long", 0.0, 30.0});
    visit("unseen_s", unseen_s,
          Field{"s", "one that should be seen and is not is gone after this", 0.0, 30.0});
  }
};

/// An object seen against what lies behind it, and where it goes; all in odom.
struct TrackedObstacle {
  int id = 0;
  Eigen::Vector2d p_odom = Eigen::Vector2d::Zero();  ///< middle of the side in view
  Eigen::Vector2d velocity_mps = Eigen::Vector2d::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();  ///< of (x, y, vx, vy)
  Eigen::Vector2d first_p_odom = Eigen::Vector2d::Zero();    ///< where it was seen first
  double first_radius_m = 0.0;                               ///< half of its width as seen then
  double radius_m = 0.0;                                     ///< half of its visible width
  double misfit = 0.0;  ///< mean squared distance of the sightings from where it was expected [sigma^2]
  int sightings = 0;
  Stamp stamp{};      ///< of p_odom
  Stamp last_seen{};  ///< of its last sighting
  bool moving = false;
  std::vector<Eigen::Vector2d> trail;  ///< where it was seen up to the scan that showed it moves; then empty

  /// Where it will be.
  Eigen::Vector2d at(double seconds) const { return p_odom + seconds * velocity_mps; }
};

/// One foreground object of a scan.
struct ScanObject {
  std::size_t first = 0;  ///< its beams
  std::size_t last = 0;
  double bearing_rad = 0.0;  ///< in the scan's frame, of its middle
  double range_m = 0.0;      ///< mean over its beams
  double width_m = 0.0;
};

/// The objects of a scan that stand out from what lies behind them on both sides; those cut by the edge of
/// the view or hidden in part are left out, since their middle is not known.
std::vector<ScanObject> foregroundObjects(const LaserScan& scan, const ObstacleTrackerParams& params);

/// Follows objects from scan to scan with a Kalman filter of constant velocity each, to tell those that move.
class ObstacleTracker {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit ObstacleTracker(const ObstacleTrackerParams& params);
  /// Other parameters from the next scan on. Throws ConfigError.
  void setParams(const ObstacleTrackerParams& params);

  /// Takes a scan in base_link in; stamps ascend. Objects at places that `ignore` accepts are left out.
  void update(const LaserScan& scan, const Pose2& odom_from_base,
              const std::function<bool(const Eigen::Vector2d& p_odom)>& ignore);
  void reset() { tracks_.clear(); }

  const std::vector<TrackedObstacle>& tracks() const { return tracks_; }
  /// Those that move now.
  std::vector<TrackedObstacle> moving() const;

 private:
  void predict(TrackedObstacle& track, Stamp stamp) const;
  void correct(TrackedObstacle& track, const Eigen::Vector2d& p_odom, const Eigen::Matrix2d& noise) const;
  void judge(TrackedObstacle& track) const;
  bool isGone(const TrackedObstacle& track, const LaserScan& scan, const Pose2& odom_from_base) const;

  ObstacleTrackerParams params_;
  std::vector<TrackedObstacle> tracks_;
  int next_id_ = 1;
};

}  // namespace frugal_nav
