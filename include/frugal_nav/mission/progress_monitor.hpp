#pragma once

#include <optional>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// When a robot with a goal counts as stuck.
struct ProgressParams {
  double stuck_s = 8.0;
  double step_m = 0.1;
  double reroute_m = 0.5;
  int max_reroutes = 12;
  double stall_s = 4.0;
  double stall_m = 0.03;
  double stall_rad = 0.1;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("stuck_s", stuck_s,
          Field{"s", "no progress for this long is stuck; longer than a turn on the spot takes", 0.5, 600.0});
    visit("step_m", step_m,
          Field{"m",
                "the remaining way must shrink by this to count as progress; above its jitter of a few "
                "grid cells",
                0.01, 2.0});
    visit("reroute_m", reroute_m,
          Field{"m",
                "a remaining way longer by this between two paths is a detour, from which progress counts "
                "anew",
                0.1, 20.0});
    visit("max_reroutes", max_reroutes,
          Field{"", "detours granted for one goal, so that a planner that swings between two ways ends too",
                0.0, 1000.0});
    visit(
        "stall_s", stall_s,
        Field{"s", "commanded to move but standing for this long is stuck: wheels or collision stop hold it",
              0.5, 600.0});
    visit("stall_m", stall_m, Field{"m", "displacement below which a commanded robot stands", 0.001, 1.0});
    visit("stall_rad", stall_rad, Field{"rad", "turn below which a commanded robot stands", 0.001, 3.0});
  }
};

/// Watches whether the way that remains to the goal gets shorter.
class ProgressMonitor {
 public:
  /// What is known at one instant; `remaining_m` is empty while there is no path to measure.
  struct Sample {
    Stamp stamp{};
    Pose2 odom_from_base;
    std::optional<double> remaining_m;
    bool commanded = false;  ///< the base was told to move
  };
  enum class Verdict {
    kMoving,
    kNoProgress,  ///< the remaining way has not shrunk for stuck_s
    kStalled,     ///< told to move, yet standing for stall_s
  };

  explicit ProgressMonitor(const ProgressParams& params) : params_(params) {}
  void setParams(const ProgressParams& params) { params_ = params; }

  /// Starts anew for a goal.
  void start(Stamp stamp);
  /// Counts progress from now on, after a recovery; the detours already granted stay counted.
  void resume(Stamp stamp);
  /// Does not count the time up to now: the robot lets something pass.
  void wait(Stamp stamp);
  /// Judges one instant; stamps must not go back.
  Verdict update(const Sample& sample);

  /// Time since the last progress [s].
  double withoutProgress_s(Stamp now) const { return toSeconds(now - last_progress_); }
  /// How much shorter the way has become since start() or resume() [m].
  double gained_m() const { return best_m_ ? first_m_ - *best_m_ : 0.0; }

 private:
  void follow(Stamp stamp, double remaining_m);
  bool stalled(const Sample& sample);

  ProgressParams params_;
  Stamp last_progress_{};
  std::optional<double> best_m_;  ///< shortest remaining way since the last progress was counted
  double first_m_ = 0.0;
  double previous_m_ = 0.0;
  int reroutes_ = 0;
  std::optional<Sample> anchor_;  ///< where the robot stood when it was first told to move
};

}  // namespace frugal_nav
