#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/mission_status.hpp>
#include <frugal_nav/common/motion_command.hpp>
#include <frugal_nav/common/odometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/control/alignment.hpp>
#include <frugal_nav/mission/observed_goal.hpp>
#include <frugal_nav/mission/progress_monitor.hpp>
#include <frugal_nav/mission/recovery.hpp>
#include <frugal_nav/mission/search.hpp>

namespace frugal_nav {

/// When a goal counts as reached and when it is given up.
struct MissionParams {
  std::string drive_mode = "lidar";
  bool needs_path = true;
  bool follow_observed = false;
  bool align_first = false;
  double xy_tolerance_m = 0.25;
  double xy_aim_m = 0.05;
  double closing_s = 1.0;
  double standing_mps = 0.02;
  double standing_radps = 0.1;
  double settle_timeout_s = 2.0;
  bool use_goal_yaw = true;
  double yaw_tolerance_rad = 0.2;
  double align_radps = 0.6;
  double align_timeout_s = 10.0;
  double patience_s = 5.0;
  double stopped_timeout_s = 5.0;
  double input_timeout_s = 1.0;
  double odom_timeout_s = 1.0;
  double goal_timeout_s = 0.0;
  ObservedGoalParams observed;
  SearchParams search;
  AlignmentParams alignment;
  ProgressParams progress;
  RecoveryParams recovery;

  template <class Visitor>
  void fields(Visitor&& visit);
  std::string check() const;
};

/// The end of a goal.
struct MissionEvent {
  std::uint32_t goal_number = 0;
  MissionPhase phase = MissionPhase::kIdle;  ///< kReached, kAborted or kCancelled
  std::string reason;
};

/// What one odometry leads to.
struct MissionOutput {
  MissionStatus status;
  std::optional<Twist2> command;  ///< in base_link, while the mission itself moves the base
};

/// Decides what the robot is doing now: takes goals in the odom frame, watches the way to them, recovers when
/// stuck, and gives up with a reason. It never reads a clock: every input brings its stamp.
class Mission {
 public:
  explicit Mission(const MissionParams& params);

  /// Takes other parameters while running. Throws ConfigError on bad ones; those before stay.
  void setParams(const MissionParams& params);

  /// Takes a goal, from now on the only one, and returns its number. Without a yaw the heading at the goal is
  /// free. A goal that is not finite, or that comes in manual mode, is aborted at once.
  std::uint32_t setGoal(const Pose2& odom_from_goal, Stamp stamp, bool with_yaw = true);
  /// Where the present goal is in odom now: one of a map moves there as the robot learns where it is. Its
  /// number stays.
  void moveGoal(const Pose2& odom_from_goal);
  /// Where the present goal is in odom is not known, for this reason: the robot stands until moveGoal() tells
  /// it, and gives up after stopped_timeout_s.
  void holdGoal(const std::string& reason);
  /// A person seen at a place of odom. With `follow_observed` the first one becomes the goal: the stand-off
  /// point before it; later ones move it, under the same number. Other goals come before it; after one of
  /// them, or when cancelled, it takes resumeFollowing() to follow again.
  void setObservedGoal(const Eigen::Vector2d& p_odom_person, Stamp stamp);
  /// From now on the next person seen is followed, and looked for if `search` says so.
  void resumeFollowing();
  /// Ends the present goal and counts one that cannot be driven to, for example "goal in an unknown frame".
  std::uint32_t refuseGoal(const std::string& reason, Stamp stamp);
  /// Ends the present goal, if there is one, as cancelled; the state says so at once.
  void cancel(const std::string& reason = "cancelled");
  /// Manual mode: the base follows cmd_vel_in; a present goal is cancelled.
  void setManual(bool manual);

  /// The planner's path to the goal, in odom; empty when it found none, and then the reason if it is known.
  void setPath(const Path2& odom_path, Stamp stamp, const std::string& reason = "");
  /// What the local planner wants.
  void setLocalCommand(const MotionCommand& command);
  /// What the base was really told, by whoever tells it: with it a robot that is held fast is told from one
  /// that the collision stop holds.
  void setBaseCommand(const Twist2& velocity, Stamp stamp);
  /// Decides for one odometry.
  MissionOutput update(const Odometry& odometry);
  /// Ends the present goal when the odometry has stopped; true when it did.
  bool checkOdometry(Stamp now);
  /// Time has jumped back: ends the present goal and forgets every input.
  void resetTime();

  /// The goals that ended since the last call, in order.
  std::vector<MissionEvent> takeEvents();
  /// The present status; its stamp is the last odometry's, zero when there is none of the present time.
  const MissionStatus& status() const { return status_; }
  /// Whether there is a goal to drive to; not while it looks for one.
  bool active() const { return activity_ != Activity::kNone && activity_ != Activity::kSearching; }
  const Pose2& goal() const { return odom_from_goal_; }
  /// How often the goal has been set or has moved: whoever passes it on looks here.
  std::uint32_t goalChanges() const { return goal_changes_; }
  /// The person that is the goal, in odom; nothing for other goals.
  std::optional<Eigen::Vector2d> person() const {
    return following_ ? std::optional<Eigen::Vector2d>(observed_.person()) : std::nullopt;
  }
  int recoveries() const { return recoveries_; }

 private:
  enum class Activity { kNone, kSearching, kFacing, kDriving, kLost, kSettling, kAligning, kRecovering };
  struct PathReport {
    Stamp stamp{};
    bool found = false;
    double remaining_m = 0.0;
    double bend_m = 0.0;
    std::string reason;
  };

  void waitForPerson(const Odometry& odometry);
  Twist2 search(const Odometry& odometry);
  void stopSearching();
  Twist2 face(const Odometry& odometry);
  Twist2 drive(const Odometry& odometry);
  Twist2 waitForGoal(const Odometry& odometry);
  Twist2 waitForMap(const Odometry& odometry);
  Twist2 settle(const Odometry& odometry);
  Twist2 align(const Odometry& odometry);
  Twist2 recover(const Odometry& odometry);

  bool isCamera() const { return params_.drive_mode == "camera"; }
  void startFollowing(const Eigen::Vector2d& p_odom_person, Stamp stamp);
  bool lostGoal(const Odometry& odometry);
  bool isBlind(Stamp now) const;
  bool letsPass() const;
  bool isCommanded(Stamp now) const;
  bool arrived(const Odometry& odometry);
  bool standing(const Odometry& odometry) const;
  bool abortedByInputs(Stamp now);
  bool hearsLocalPlanner(Stamp now) const;
  std::string stoppedReason(Stamp now) const;
  std::string obstruction(Stamp now);
  void watchProgress(const Odometry& odometry);
  void startRecovery(const Odometry& odometry, const std::string& cause);

  void beginGoal(Stamp stamp);
  void enter(Activity activity, Stamp stamp, const std::string& reason);
  void finish(MissionPhase phase, const std::string& reason);

  MissionParams params_;
  ProgressMonitor progress_;
  Recovery recovery_;
  ObservedGoal observed_;
  Search search_;
  Alignment alignment_;
  MissionStatus status_;
  std::vector<MissionEvent> events_;

  Activity activity_ = Activity::kNone;
  Stamp activity_start_{};
  Pose2 odom_from_goal_;
  std::string hold_reason_;  ///< why the goal's place is not known; empty: it is
  std::uint32_t goal_changes_ = 0;
  bool follows_ = true;                           ///< the next person seen is taken for the goal
  bool following_ = false;                        ///< the present goal is a person
  bool searches_ = true;                          ///< nobody has been seen or looked for yet
  std::optional<Stamp> alone_since_;              ///< sees nobody, though it could
  std::optional<Eigen::Vector2d> p_done_person_;  ///< where the last one was when its goal ended
  Pose2 odom_from_base_;                          ///< of the last odometry
  bool with_yaw_ = true;
  Stamp goal_start_{};
  bool started_ = false;  ///< an odometry has come since the goal was set
  int recoveries_ = 0;
  double closest_m_ = 0.0;  ///< within the tolerance: smallest distance so far, and when
  Stamp closest_at_{};
  bool near_goal_ = false;
  std::optional<Stamp> stopped_since_;
  std::optional<Stamp> obstructed_since_;

  std::optional<PathReport> path_;
  std::optional<MotionCommand> local_;
  struct BaseReport {
    Stamp stamp{};
    Twist2 velocity;
  };
  std::optional<BaseReport> base_;
  std::optional<Stamp> last_odometry_;
  std::optional<Stamp> last_path_;
  std::optional<Stamp> last_local_;
};

template <class Visitor>
void MissionParams::fields(Visitor&& visit) {
  visit("drive_mode", drive_mode,
        Field{"", "who drives to the goal: avoidance/command (lidar) or path (camera)",
              -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
              "lidar|camera"});
  visit("needs_path", needs_path,
        Field{"", "false where the local planner heads for the goal itself and no planner runs"});
  visit("follow_observed", follow_observed,
        Field{"", "take the person on goal/observed for the goal, and follow it"});
  visit("align_first", align_first, Field{"", "turn to face that person before driving [paper]"});
  visit("xy_tolerance_m", xy_tolerance_m,
        Field{"m", "at the goal when within this; leaves 0.05 m of braking to the 0.30 m goal radius", 0.01,
              5.0});
  visit("xy_aim_m", xy_aim_m,
        Field{"m", "within the tolerance the robot drives on until this near, or until it gets no nearer",
              0.0, 5.0});
  visit("closing_s", closing_s,
        Field{"s", "gets no nearer when the distance has not shrunk for this long", 0.1, 60.0});
  visit("standing_mps", standing_mps,
        Field{"m/s", "stands below this: about one encoder tick in 20 ms", 0.0, 1.0});
  visit("standing_radps", standing_radps,
        Field{"rad/s", "stands below this: about one encoder tick of one wheel in 20 ms", 0.0, 3.0});
  visit("settle_timeout_s", settle_timeout_s,
        Field{"s", "counts as standing after this, however noisy the odometry", 0.1, 60.0});
  visit("use_goal_yaw", use_goal_yaw,
        Field{"", "turn to the goal's heading, as clients of move_base expect"});
  visit("yaw_tolerance_rad", yaw_tolerance_rad, Field{"rad", "heading error that is good enough", 0.01, 3.2});
  visit("align_radps", align_radps, Field{"rad/s", "fastest turn on the spot at the goal", 0.05, 3.0});
  visit("align_timeout_s", align_timeout_s,
        Field{"s", "reached, even so, when the turn takes longer; half a turn at align_radps takes 5.2 s",
              0.5, 120.0});
  visit("patience_s", patience_s,
        Field{"s", "waits this long for what blocks the way to go away before it recovers", 0.0, 600.0});
  visit("stopped_timeout_s", stopped_timeout_s,
        Field{"s", "gives up when the local planner has been stopped for this long, by a lost scan for one",
              0.1, 600.0});
  visit(
      "input_timeout_s", input_timeout_s,
      Field{"s", "a path or local command older than this has stopped; several scans of 5.5 Hz", 0.1, 60.0});
  visit("odom_timeout_s", odom_timeout_s,
        Field{"s", "gives up without odometry for this long; the base stands after its own, shorter time-out",
              0.05, 60.0});
  visit("goal_timeout_s", goal_timeout_s, Field{"s", "gives up after this long; 0 never does", 0.0, 86400.0});
  visit("observed", observed);
  visit("search", search);
  visit("alignment", alignment);
  visit("progress", progress);
  visit("recovery", recovery);
}

}  // namespace frugal_nav
