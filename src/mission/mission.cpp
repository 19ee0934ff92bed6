#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include <frugal_nav/mission/mission.hpp>
#include <frugal_nav/planning/path_shape.hpp>

namespace frugal_nav {
namespace {

// A robot that has come to stand this far beyond the tolerance drives up once more.
constexpr double kReleaseMargin_m = 0.05;
// The distance must shrink by this to count as getting nearer: above the encoder's resolution.
constexpr double kNearer_m = 0.01;
// Turning to the goal's heading slows down over this angle, to no less than this share of the full rate:
// slower turns may stall in the motors' friction.
constexpr double kAlignRamp_rad = 0.6;
constexpr double kSlowestShare = 1.0 / 3.0;

std::string seconds(double s) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", s);
  return text;
}

bool wentBack(Stamp stamp, const std::optional<Stamp>& last) { return last && stamp < *last; }

}  // namespace

std::string MissionParams::check() const {
  if (xy_aim_m > xy_tolerance_m) return "xy_aim_m must not exceed xy_tolerance_m";
  return "";
}

Mission::Mission(const MissionParams& params)
    : params_(params),
      progress_(params.progress),
      recovery_(params.recovery),
      observed_(params.observed),
      search_(params.search),
      alignment_(params.alignment) {
  validate(params, "mission");
}

void Mission::setParams(const MissionParams& params) {
  validate(params, "mission");
  if (params.follow_observed && !params_.follow_observed) resumeFollowing();
  params_ = params;
  progress_.setParams(params.progress);
  recovery_.setParams(params.recovery);
  observed_.setParams(params.observed);
  search_.setParams(params.search);
  if (!params.follow_observed || !params.search.enabled) stopSearching();
  alignment_ = Alignment(params.alignment);
}

std::uint32_t Mission::setGoal(const Pose2& odom_from_goal, Stamp stamp, bool with_yaw) {
  if (!odom_from_goal.isFinite()) return refuseGoal("goal is not finite", stamp);
  if (status_.mode == Mode::kManual) return refuseGoal("goal refused: manual mode is on", stamp);
  beginGoal(stamp);
  follows_ = false;
  odom_from_goal_ = odom_from_goal;
  ++goal_changes_;
  with_yaw_ = with_yaw && params_.use_goal_yaw;
  enter(Activity::kDriving, stamp, "driving to the goal");
  return status_.goal_number;
}

std::uint32_t Mission::refuseGoal(const std::string& reason, Stamp stamp) {
  const bool manual = status_.mode == Mode::kManual;
  beginGoal(stamp);
  finish(MissionPhase::kAborted, reason);
  if (manual) status_.mode = Mode::kManual;
  return status_.goal_number;
}

void Mission::cancel(const std::string& reason) {
  follows_ = false;
  stopSearching();
  if (active()) finish(MissionPhase::kCancelled, reason);
}

void Mission::setManual(bool manual) {
  if (manual) {
    cancel("cancelled: manual mode");
    status_.mode = Mode::kManual;
  } else if (status_.mode == Mode::kManual) {
    status_.mode = Mode::kIdle;
  }
}

void Mission::setPath(const Path2& odom_path, Stamp stamp, const std::string& reason) {
  if (wentBack(stamp, last_path_)) resetTime();
  last_path_ = stamp;
  path_ = PathReport{stamp, !odom_path.empty(), 0.0, bendOf(odom_path), reason};
  // A rolling window's path may end at its edge: the rest is counted as a straight line.
  if (path_->found) path_->remaining_m = lengthOf(odom_path) + distance(odom_path.back(), odom_from_goal_);
}

void Mission::setLocalCommand(const MotionCommand& command) {
  if (wentBack(command.stamp, last_local_)) resetTime();
  last_local_ = command.stamp;
  local_ = command;
}

void Mission::setBaseCommand(const Twist2& velocity, Stamp stamp) { base_ = BaseReport{stamp, velocity}; }

MissionOutput Mission::update(const Odometry& odometry) {
  if (wentBack(odometry.stamp, last_odometry_)) resetTime();
  last_odometry_ = odometry.stamp;
  status_.stamp = odometry.stamp;
  odom_from_base_ = odometry.odom_from_base;
  if (active() && !odometry.odom_from_base.isFinite())
    finish(MissionPhase::kAborted, "odometry lost: it is not finite");
  if (active() && !started_) {
    started_ = true;
    goal_start_ = activity_start_ = odometry.stamp;
    progress_.start(odometry.stamp);
  }
  if (active() && params_.goal_timeout_s > 0.0 &&
      toSeconds(odometry.stamp - goal_start_) >= params_.goal_timeout_s)
    finish(MissionPhase::kAborted, "goal time-out: not reached within " + seconds(params_.goal_timeout_s));

  if (active() && !hold_reason_.empty() && activity_ != Activity::kLost)
    enter(Activity::kLost, odometry.stamp, hold_reason_);

  Twist2 command;
  switch (activity_) {
    case Activity::kFacing:
      command = face(odometry);
      break;
    case Activity::kDriving:
      command = drive(odometry);
      break;
    case Activity::kLost:
      command = waitForGoal(odometry);
      break;
    case Activity::kSettling:
      command = settle(odometry);
      break;
    case Activity::kAligning:
      command = align(odometry);
      break;
    case Activity::kRecovering:
      command = recover(odometry);
      break;
    case Activity::kSearching:
      command = search(odometry);
      break;
    case Activity::kNone:
      waitForPerson(odometry);
      break;
  }
  MissionOutput output{status_, std::nullopt};
  if (status_.mode == Mode::kAligning || status_.mode == Mode::kRecovering) output.command = command;
  return output;
}

bool Mission::checkOdometry(Stamp now) {
  if (!active()) return false;
  if (goal_start_ == Stamp{}) goal_start_ = now;  // the goal came before the clock did
  const Stamp since = started_ ? *last_odometry_ : goal_start_;
  const double age_s = toSeconds(now - since);
  if (age_s < params_.odom_timeout_s) return false;
  finish(MissionPhase::kAborted, "odometry lost: none for " + seconds(age_s));
  return true;
}

void Mission::resetTime() {
  if (active()) finish(MissionPhase::kAborted, "time jumped back");
  stopSearching();
  searches_ = true;
  alone_since_.reset();
  p_done_person_.reset();
  status_.stamp = Stamp{};
  path_.reset();
  local_.reset();
  base_.reset();
  last_odometry_.reset();
  last_path_.reset();
  last_local_.reset();
}

std::vector<MissionEvent> Mission::takeEvents() { return std::exchange(events_, {}); }

Twist2 Mission::drive(const Odometry& odometry) {
  if (arrived(odometry)) {
    enter(Activity::kSettling, odometry.stamp, "at the goal, coming to a stand");
    return {};
  }
  if (lostGoal(odometry) || abortedByInputs(odometry.stamp)) return {};
  if (stopped_since_) {
    progress_.resume(odometry.stamp);  // no progress is to be expected
  } else {
    watchProgress(odometry);
  }
  return {};
}

Twist2 Mission::settle(const Odometry& odometry) {
  if (!standing(odometry) && toSeconds(odometry.stamp - activity_start_) < params_.settle_timeout_s)
    return {};
  if (distance(odometry.odom_from_base, odom_from_goal_) > params_.xy_tolerance_m + kReleaseMargin_m) {
    progress_.resume(odometry.stamp);
    enter(Activity::kDriving, odometry.stamp, "driving to the goal: it slipped past");
  } else if (with_yaw_) {
    enter(Activity::kAligning, odometry.stamp, "turning to the goal's heading");
    return align(odometry);
  } else {
    finish(MissionPhase::kReached, "goal reached");
  }
  return {};
}

Twist2 Mission::align(const Odometry& odometry) {
  const double error_rad = angleBetween(odometry.odom_from_base.yaw_rad, odom_from_goal_.yaw_rad);
  if (toSeconds(odometry.stamp - activity_start_) >= params_.align_timeout_s) {
    finish(MissionPhase::kReached, "goal reached, but its heading was not within " +
                                       seconds(params_.align_timeout_s) + ": the turn is held up");
    return {};
  }
  if (isBlind(odometry.stamp)) return {};
  // Aims well inside the tolerance, so that braking does not leave it.
  if (std::abs(error_rad) <= 0.5 * params_.yaw_tolerance_rad) {
    if (standing(odometry)) finish(MissionPhase::kReached, "goal reached");
    return {};
  }
  const double share = std::clamp(std::abs(error_rad) / kAlignRamp_rad, kSlowestShare, 1.0);
  return {0.0, std::copysign(share * params_.align_radps, error_rad)};
}

Twist2 Mission::recover(const Odometry& odometry) {
  // Without a scan nothing guards the motion: stand until it is back, or give up.
  if (abortedByInputs(odometry.stamp) || stopped_since_) return {};
  const Twist2 command = recovery_.update(odometry);
  if (recovery_.done()) {
    progress_.resume(odometry.stamp);
    obstructed_since_.reset();
    enter(Activity::kDriving, odometry.stamp, "driving to the goal after a recovery");
  }
  return command;
}

bool Mission::arrived(const Odometry& odometry) {
  const double distance_m = distance(odometry.odom_from_base, odom_from_goal_);
  if (distance_m > params_.xy_tolerance_m) {
    near_goal_ = false;
    return false;
  }
  if (!near_goal_ || distance_m < closest_m_ - kNearer_m) {
    near_goal_ = true;
    closest_m_ = distance_m;
    closest_at_ = odometry.stamp;
  }
  return distance_m <= params_.xy_aim_m || toSeconds(odometry.stamp - closest_at_) >= params_.closing_s;
}

bool Mission::standing(const Odometry& odometry) const {
  return std::abs(odometry.twist.v_mps) <= params_.standing_mps &&
         std::abs(odometry.twist.w_radps) <= params_.standing_radps;
}

void Mission::watchProgress(const Odometry& odometry) {
  ProgressMonitor::Sample sample{odometry.stamp, odometry.odom_from_base, std::nullopt, false};
  if (!params_.needs_path)
    sample.remaining_m = distance(odometry.odom_from_base, odom_from_goal_);
  else if (path_ && path_->found && path_->stamp >= goal_start_)
    sample.remaining_m = path_->remaining_m;
  sample.commanded = isCommanded(odometry.stamp);
  if (letsPass()) progress_.wait(odometry.stamp);
  const ProgressMonitor::Verdict verdict = progress_.update(sample);
  if (progress_.gained_m() >= params_.recovery.regained_m) recoveries_ = 0;

  const std::string obstructed = obstruction(odometry.stamp);
  if (!obstructed.empty()) {
    if (toSeconds(odometry.stamp - *obstructed_since_) >= params_.patience_s)
      startRecovery(odometry, obstructed);
  } else if (verdict == ProgressMonitor::Verdict::kStalled && isCamera() && base_) {
    finish(MissionPhase::kAborted,
           "hit: the base is told to move but stands for " + seconds(params_.progress.stall_s));
  } else if (verdict == ProgressMonitor::Verdict::kStalled) {
    startRecovery(odometry, "stuck: told to move but standing for " + seconds(params_.progress.stall_s));
  } else if (verdict == ProgressMonitor::Verdict::kNoProgress) {
    startRecovery(odometry, "stuck: no progress for " + seconds(progress_.withoutProgress_s(odometry.stamp)));
  }
}

void Mission::startRecovery(const Odometry& odometry, const std::string& cause) {
  if (recoveries_ >= params_.recovery.max_recoveries) {
    finish(MissionPhase::kAborted, cause + " after " + std::to_string(recoveries_) + " recoveries");
    return;
  }
  ++recoveries_;
  if (isCamera()) {
    // What lies behind is out of view: look where the way should be, then to either side of the goal in turn,
    // ever farther.
    const double to_goal_rad = bearingTo(odometry.odom_from_base, odom_from_goal_.position());
    const bool has_looked = recoveries_ > 1 || std::abs(to_goal_rad) < 0.5 * params_.observed.view_rad;
    const double aside_rad = (recoveries_ % 2 == 1 ? 1.0 : -1.0) * (0.6 + 0.3 * recoveries_);
    recovery_.start(odometry, has_looked ? to_goal_rad + aside_rad : to_goal_rad, false);
  } else {
    recovery_.start(odometry, local_ ? local_->clear_bearing_rad : 0.0);
  }
  enter(Activity::kRecovering, odometry.stamp, cause);
}

void Mission::beginGoal(Stamp stamp) {
  if (active()) finish(MissionPhase::kCancelled, "preempted by a new goal");
  ++status_.goal_number;
  following_ = false;
  hold_reason_.clear();
  alone_since_.reset();
  goal_start_ = activity_start_ = stamp;
  started_ = false;
  near_goal_ = false;
  recoveries_ = 0;
  path_.reset();
  stopped_since_.reset();
  obstructed_since_.reset();
  progress_.start(stamp);
}

void Mission::enter(Activity activity, Stamp stamp, const std::string& reason) {
  activity_ = activity;
  activity_start_ = stamp;
  status_.reason = reason;
  status_.phase = activity == Activity::kRecovering  ? MissionPhase::kRecovering
                  : activity == Activity::kSearching ? MissionPhase::kIdle
                                                     : MissionPhase::kDriving;
  switch (activity) {
    case Activity::kDriving:
      status_.mode = isCamera() ? Mode::kCamera : Mode::kLidar;
      break;
    case Activity::kSearching:
    case Activity::kFacing:
    case Activity::kLost:
    case Activity::kSettling:
    case Activity::kAligning:
      status_.mode = Mode::kAligning;
      break;
    case Activity::kRecovering:
      status_.mode = Mode::kRecovering;
      break;
    case Activity::kNone:
      status_.mode = Mode::kIdle;
      break;
  }
}

void Mission::finish(MissionPhase phase, const std::string& reason) {
  const bool was_lost = activity_ == Activity::kLost;
  activity_ = Activity::kNone;
  status_.mode = Mode::kIdle;
  status_.phase = phase;
  status_.reason = reason;
  events_.push_back({status_.goal_number, phase, reason});
  // One who was lost is followed as soon as he is seen again; of one who was reached, or cannot be, it takes
  // another place.
  if (following_ && !was_lost) p_done_person_ = observed_.person();
  following_ = false;
}

}  // namespace frugal_nav
