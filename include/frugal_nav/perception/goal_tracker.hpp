#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/perception/head_range.hpp>

namespace frugal_nav {

/// When a sighting becomes the goal, and how long it stays.
struct GoalTrackerParams {
  double start_score = 0.5;
  double keep_score = 0.25;
  int confirm_sightings = 3;
  double confirm_within_s = 1.0;
  double lost_after_s = 2.0;
  double forget_unseeable_s = 60.0;
  double gate_sigma = 3.0;
  double min_gate_m = 0.5;
  double height_gate_m = 0.3;
  double drift_m2ps = 0.0005;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("start_score", start_score,
          Field{"", "score from which a detection can become the goal", 0.0, 1.0});
    visit("keep_score", keep_score,
          Field{"", "score from which a detection keeps the goal alive; lower, so that it does not flicker",
                0.0, 1.0});
    visit("confirm_sightings", confirm_sightings,
          Field{"", "sightings in one place that make a goal: one false detection makes none", 1, 100});
    visit("confirm_within_s", confirm_within_s,
          Field{"s", "longest gap between those sightings", 0.01, 60.0});
    visit("lost_after_s", lost_after_s,
          Field{"s", "a goal that should be in view and is not seen that long is lost", 0.05, 600.0});
    visit("forget_unseeable_s", forget_unseeable_s,
          Field{"s", "the same for a goal out of the camera's view: near a person the head leaves the image",
                0.05, 36000.0});
    visit("gate_sigma", gate_sigma,
          Field{"", "a sighting farther off is something else, in standard deviations", 1.0, 10.0});
    visit("min_gate_m", min_gate_m,
          Field{"m", "a sighting of start_score this close belongs to the goal in any case: people shift",
                0.0, 5.0});
    visit("height_gate_m", height_gate_m,
          Field{"m", "a sighting this much higher or lower over the floor is something else", 0.0, 3.0});
    visit("drift_m2ps", drift_m2ps,
          Field{"m^2/s", "how fast the goal's variance grows: a standing person sways", 0.0, 10.0});
  }
  std::string check() const {
    return keep_score <= start_score ? "" : "keep_score must not exceed start_score";
  }
};

/// The goal as it is known at one instant.
struct TrackedGoal {
  Stamp stamp{};
  Stamp last_seen{};
  int class_id = 0;
  double score = 0.0;                                       ///< of the last sighting
  Eigen::Vector2d p_odom = Eigen::Vector2d::Zero();         ///< [m]
  Eigen::Matrix2d covariance_m2 = Eigen::Matrix2d::Zero();  ///< of p_odom, with the head's unknown size
  double above_floor_m = 0.0;
  int sightings = 0;  ///< that went into it
};

/// One goal followed over frames in odom: a Kalman filter on its place, standing or slow. The noise of the
/// boxes averages out over frames; what all frames share, the head's unknown size, stays in the covariance.
/// A missed frame is not a lost goal; a lost goal is found anew by the sightings that would make a first one.
class GoalTracker {
 public:
  enum class State {
    kNone,    ///< nothing was found yet
    kSeen,    ///< in the last frame
    kUnseen,  ///< not in the last frame; its place is kept
    kLost     ///< not seen for too long
  };

  /// Throws ConfigError on parameters out of range.
  explicit GoalTracker(const GoalTrackerParams& params);

  /// One frame: what was located in it, seen from `odom_from_base`. `could_see` tells whether the goal, where
  /// it is thought to be, lies in the camera's view. A stamp before the last one forgets everything first;
  /// one equal to it changes nothing.
  State update(Stamp stamp, const Pose2& odom_from_base, const std::vector<HeadSighting>& sightings,
               bool could_see);

  State state() const { return state_; }
  /// The goal while it is kSeen or kUnseen.
  std::optional<TrackedGoal> goal() const;
  /// A place of the goal from elsewhere than a head, with its covariance. False for one too far off, which is
  /// ignored.
  bool place(const Eigen::Vector2d& p_odom, const Eigen::Matrix2d& covariance_m2);
  /// What it was told so far may be off by this standard deviation: later sightings count more.
  void doubt(double sigma_m);
  /// Forgets everything.
  void reset();

 private:
  struct Track {
    TrackedGoal goal;                // its covariance without the common part
    Eigen::Matrix2d common_odom_m2;  // of the last sighting
  };
  struct Seen {  // a sighting in odom
    const HeadSighting* sighting = nullptr;
    Eigen::Vector2d p_odom;
    Eigen::Matrix2d noise_m2;
    Eigen::Matrix2d common_m2;
  };

  Seen* nearest(const Track& track, std::vector<Seen>& seen, double min_score) const;
  void absorb(Track& track, const Seen& seen, Stamp stamp) const;
  void updateGoal(Stamp stamp, std::vector<Seen>& seen, bool could_see);
  void updateCandidate(Stamp stamp, std::vector<Seen>& seen);

  GoalTrackerParams params_;
  State state_ = State::kNone;
  std::optional<Stamp> last_stamp_;
  std::optional<Track> goal_;
  std::optional<Track> candidate_;
  Stamp last_excused_{};  // last instant at which the goal was seen or could not be
};

}  // namespace frugal_nav
