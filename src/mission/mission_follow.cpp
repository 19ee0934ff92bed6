#include <cmath>

#include <frugal_nav/mission/mission.hpp>

// A person as the goal: looked for, taken from goal/observed, faced, and waited for where it is lost.

namespace frugal_nav {

void Mission::setObservedGoal(const Eigen::Vector2d& p_odom_person, Stamp stamp) {
  if (!params_.follow_observed || !p_odom_person.allFinite() || status_.mode == Mode::kManual) return;
  if (following_) {
    if (observed_.see(p_odom_person, odom_from_base_.position())) {
      odom_from_goal_ = observed_.standOff();
      ++goal_changes_;
    }
    return;
  }
  if (active() || !follows_ || !last_odometry_) return;
  const bool stays = p_done_person_ && (p_odom_person - *p_done_person_).norm() < params_.observed.restart_m;
  if (!stays) startFollowing(p_odom_person, stamp);
}

void Mission::resumeFollowing() {
  follows_ = searches_ = true;
  p_done_person_.reset();
}

/// Turns to look for a person when none has been seen for a while. Only while images come in: blind it would
/// turn for nothing.
void Mission::waitForPerson(const Odometry& odometry) {
  const bool wanted = params_.follow_observed && params_.search.enabled && follows_ && searches_ &&
                      status_.mode == Mode::kIdle && hearsLocalPlanner(odometry.stamp);
  if (!wanted) {
    alone_since_.reset();
    return;
  }
  if (!alone_since_) alone_since_ = odometry.stamp;
  if (toSeconds(odometry.stamp - *alone_since_) < params_.search.after_s) return;
  searches_ = false;
  search_.start(odometry);
  enter(Activity::kSearching, odometry.stamp, "turning to look for a person");
}

Twist2 Mission::search(const Odometry& odometry) {
  const Twist2 command = search_.update(odometry);
  if (search_.state() == Search::State::kTurning) {
    return hearsLocalPlanner(odometry.stamp) ? command : Twist2{};
  }
  const bool done = search_.state() == Search::State::kDone;
  beginGoal(odometry.stamp);
  finish(MissionPhase::kAborted, done ? "no person found: none was seen in a full turn"
                                      : "no person found: none was seen, and the turn is held up");
  return {};
}

void Mission::stopSearching() {
  if (activity_ != Activity::kSearching) return;
  activity_ = Activity::kNone;
  status_.mode = Mode::kIdle;
  status_.reason.clear();
}

void Mission::startFollowing(const Eigen::Vector2d& p_odom_person, Stamp stamp) {
  beginGoal(stamp);
  following_ = true;
  searches_ = false;
  p_done_person_.reset();
  observed_.start(p_odom_person, odom_from_base_.position(), stamp);
  odom_from_goal_ = observed_.standOff();
  ++goal_changes_;
  with_yaw_ = params_.use_goal_yaw;
  alignment_.reset();
  if (params_.align_first) {
    enter(Activity::kFacing, stamp, "turning to face the person");
  } else {
    enter(Activity::kDriving, stamp, "driving to the person");
  }
}

Twist2 Mission::face(const Odometry& odometry) {
  if (lostGoal(odometry)) return {};
  if (isBlind(odometry.stamp)) return {};
  const double bearing_rad = bearingTo(odometry.odom_from_base, observed_.person());
  const AlignmentStep step = alignment_.updateBearing(odometry.stamp, params_.observed.view_rad, bearing_rad);
  const bool late = toSeconds(odometry.stamp - activity_start_) >= params_.align_timeout_s;
  if (step.status != AlignmentStep::Status::kDone && !late) return {0.0, step.w_radps};
  progress_.resume(odometry.stamp);
  enter(Activity::kDriving, odometry.stamp, "driving to the person");
  return {};
}

/// Whether the person who is the goal has been lost, and the robot now stands.
bool Mission::lostGoal(const Odometry& odometry) {
  if (!following_) return false;
  observed_.watch(odometry.stamp, odometry.odom_from_base, path_ ? path_->bend_m : 0.0);
  if (!observed_.isLost()) return false;
  enter(Activity::kLost, odometry.stamp, "goal lost: the person is not where it was seen last");
  return true;
}

Twist2 Mission::waitForGoal(const Odometry& odometry) {
  if (!following_) return waitForMap(odometry);
  observed_.watch(odometry.stamp, odometry.odom_from_base, 0.0);
  if (!observed_.isLost()) {
    progress_.resume(odometry.stamp);
    enter(Activity::kDriving, odometry.stamp, "driving to the person, seen again");
  } else if (toSeconds(odometry.stamp - activity_start_) >= params_.observed.lost_timeout_s) {
    finish(MissionPhase::kAborted, "goal lost: the person was not seen again");
  }
  return {};
}

/// Whether what drives the robot is at work: with or without a goal it answers each image or scan.
bool Mission::hearsLocalPlanner(Stamp now) const {
  const std::optional<Stamp>& last = isCamera() ? last_path_ : last_local_;
  return last && toSeconds(now - *last) <= params_.input_timeout_s;
}

/// Whether the camera that must guard a turn on the spot has fallen silent.
bool Mission::isBlind(Stamp now) const { return isCamera() && !hearsLocalPlanner(now); }

/// Whether the local planner stands for something that moves.
bool Mission::letsPass() const {
  return !isCamera() && local_ && local_->status == MotionCommand::Status::kDriving &&
         local_->holds == MotionCommand::Holds::kNothing;
}

/// Whether the base is told to move now.
bool Mission::isCommanded(Stamp now) const {
  if (!isCamera()) return local_ && local_->holds != MotionCommand::Holds::kNothing;
  if (base_) {  // by so much that a robot which is not held leaves its place
    constexpr double kFactor = 2.0;
    const ProgressParams& progress = params_.progress;
    const bool moves = std::abs(base_->velocity.v_mps) > kFactor * progress.stall_m / progress.stall_s ||
                       std::abs(base_->velocity.w_radps) > kFactor * progress.stall_rad / progress.stall_s;
    return moves && toSeconds(now - base_->stamp) < params_.input_timeout_s;
  }
  return path_ && path_->found && path_->stamp >= goal_start_ && path_->remaining_m > params_.xy_aim_m;
}

}  // namespace frugal_nav
