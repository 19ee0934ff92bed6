#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/perception/column_surface.hpp>

namespace frugal_nav {

/// What is one obstacle, and how its motion is told.
struct ObstacleMotionParams {
  double join_m = 0.25;
  int min_columns = 2;
  double nearest_share = 0.15;
  double goal_radius_m = 0.45;
  double gate_m = 0.5;
  double acceleration_mps2 = 0.6;
  double position_sigma_m = 0.06;
  double min_speed_mps = 0.15;
  double moving_sigma = 3.0;
  double min_age_s = 0.4;
  double forget_s = 1.5;
  double max_speed_mps = 2.5;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("join_m", join_m,
          Field{"m", "neighbouring columns whose surfaces lie nearer than this are one obstacle", 0.01, 2.0});
    visit("min_columns", min_columns,
          Field{"", "narrower obstacles are noise, unless nothing else is seen", 1, 100});
    visit("nearest_share", nearest_share,
          Field{"", "share of an obstacle's columns that may be nearer than its nearest place: noise", 0.0,
                0.5});
    visit("goal_radius_m", goal_radius_m,
          Field{"m", "what is seen this near the person who is the goal belongs to him", 0.0, 2.0});
    visit("gate_m", gate_m,
          Field{"m", "an obstacle farther from where one was expected is another", 0.05, 5.0});
    visit("acceleration_mps2", acceleration_mps2,
          Field{"m/s^2", "how fast obstacles change their velocity: people do in a second", 0.01, 20.0});
    visit("position_sigma_m", position_sigma_m,
          Field{"m", "how far the middle of what is seen of an obstacle jumps between images", 0.001, 1.0});
    visit("min_speed_mps", min_speed_mps, Field{"m/s", "slower obstacles stand", 0.0, 5.0});
    visit("moving_sigma", moving_sigma,
          Field{"", "a speed less sure than this many standard deviations is none", 0.0, 10.0});
    visit("min_age_s", min_age_s, Field{"s", "an obstacle seen for less has no velocity yet", 0.0, 10.0});
    visit("forget_s", forget_s, Field{"s", "one not seen for longer is forgotten", 0.05, 60.0});
    visit("max_speed_mps", max_speed_mps,
          Field{"m/s", "a faster one is two obstacles taken for one", 0.1, 20.0});
  }
};

/// One thing in view, from neighbouring columns.
struct SeenObstacle {
  int first_column = 0;
  int last_column = 0;
  int nearest_column = 0;
  Eigen::Vector2d p_base = Eigen::Vector2d::Zero();       ///< its nearest place
  Eigen::Vector2d middle_base = Eigen::Vector2d::Zero();  ///< mean over its columns
  double distance_m = 0.0;
  bool is_cut_off = false;  ///< it reaches the image's edge: its middle is not known
};

/// The things in view, nearest first; columns near `p_base_goal` are left out.
std::vector<SeenObstacle> joinColumns(const std::vector<ColumnSurface>& surfaces,
                                      const std::optional<Eigen::Vector2d>& p_base_goal,
                                      const ObstacleMotionParams& params);

/// The motion of the nearest obstacles in odom: one Kalman filter of constant velocity each.
class ObstacleMotion {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit ObstacleMotion(const ObstacleMotionParams& params);

  /// Takes what one image shows; velocities in odom [m/s], one for each, zero for what stands. Stamps must
  /// not go back: reset() first.
  std::vector<Eigen::Vector2d> update(Stamp stamp, const Pose2& odom_from_base,
                                      const std::vector<SeenObstacle>& seen);
  void reset() { tracks_.clear(); }

 private:
  struct Track {
    Stamp born{};
    Stamp seen{};
    Stamp stamp{};
    Eigen::Vector4d state = Eigen::Vector4d::Zero();  // x, y, vx, vy
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  };

  Track begin(Stamp stamp, const Eigen::Vector2d& p_odom) const;
  void predict(Stamp stamp, Track& track) const;
  void correct(const Eigen::Vector2d& p_odom, Stamp stamp, Track& track) const;
  Eigen::Vector2d velocityOf(const Track& track) const;

  ObstacleMotionParams params_;
  std::vector<Track> tracks_;
};

}  // namespace frugal_nav
