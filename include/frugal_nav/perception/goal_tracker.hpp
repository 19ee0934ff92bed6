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
  double stand_s = 0.6;
  double lost_after_s = 2.0;
  double forget_unseeable_s = 60.0;
  double gate_sigma = 3.0;
  double shift_m = 1.0;
  double alike_s = 0.5;
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
    visit("stand_s", stand_s,
          Field{"s", "for how long it must have been seen in that place: who walks by is not the goal", 0.0,
                60.0});
    visit("lost_after_s", lost_after_s,
          Field{"s", "a goal that should be in view and is not seen that long is lost", 0.05, 600.0});
    visit("forget_unseeable_s", forget_unseeable_s,
          Field{"s", "the same for a goal out of the camera's view: near a person the head leaves the image",
                0.05, 36000.0});
    visit("gate_sigma", gate_sigma,
          Field{"", "a sighting farther off is something else, in standard deviations", 1.0, 10.0});
    visit("shift_m", shift_m,
          Field{"m",
                "one found standing this near to a goal that is not seen there any more is that goal: people "
                "shift, and its place may have been wrong",
                0.0, 5.0});
    visit("alike_s", alike_s,
          Field{"s", "what two frames tell within this time errs alike: together they count as one", 0.0,
                10.0});
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

/// One goal followed over frames in odom: a Kalman filter on the place of its head, its height over the floor
/// and its size over the assumed one. All frames see the same head: how it rises in the image, and how its
/// bearing turns, while the robot drives tells the distance, and so the size, better than any assumed size.
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
  /// Which of the last frame's sightings was the goal's; set while kSeen.
  std::optional<std::size_t> seenBy() const { return seen_by_; }
  /// A place of the goal from elsewhere than a head, with its covariance. False for one too far off, which is
  /// ignored.
  bool place(Stamp stamp, const Eigen::Vector2d& p_odom, const Eigen::Matrix2d& covariance_m2);
  /// Forgets everything.
  void reset();

 private:
  struct Track {
    TrackedGoal goal;                                 // what the state does not say
    Stamp stamp{};                                    // of the state
    Stamp since{};                                    // first sighting
    Stamp placed{};                                   // last place from elsewhere
    Eigen::Vector4d state = Eigen::Vector4d::Zero();  // place in odom, height over the floor, size
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  };
  struct Seen {  // a sighting in odom
    const HeadSighting* sighting = nullptr;
    std::size_t index = 0;
    Eigen::Vector3d p_odom;
    Eigen::Vector3d from_eye;
    Eigen::Matrix3d noise_m2;
  };
  struct Innovation;

  void predict(std::optional<Track>& track, Stamp stamp) const;
  Track trackOf(const Seen& seen, Stamp stamp) const;
  Innovation compare(const Track& track, const Seen& seen, Stamp stamp) const;
  Seen* nearest(const Track& track, std::vector<Seen>& seen, double min_score, Stamp stamp) const;
  void absorb(Track& track, const Seen& seen, Stamp stamp) const;
  void updateGoal(Stamp stamp, std::vector<Seen>& seen, bool could_see);
  void updateCandidate(Stamp stamp, std::vector<Seen>& seen);
  bool replacesGoal(const Track& candidate, Stamp stamp) const;

  GoalTrackerParams params_;
  State state_ = State::kNone;
  std::optional<Stamp> last_stamp_;
  std::optional<Track> goal_;
  std::optional<Track> candidate_;
  std::optional<std::size_t> seen_by_;
  Stamp last_excused_{};  // last instant at which the goal was seen or could not be
};

}  // namespace frugal_nav
