#include <frugal_nav/mission/mission.hpp>

// What planner and local planner say: when they have stopped, and what stands in the way.

namespace frugal_nav {

bool Mission::abortedByInputs(Stamp now) {
  const std::string reason = stoppedReason(now);
  if (reason.empty()) {
    stopped_since_.reset();
    return false;
  }
  if (!stopped_since_) stopped_since_ = now;
  if (toSeconds(now - *stopped_since_) < params_.stopped_timeout_s) return false;
  finish(MissionPhase::kAborted, reason);
  return true;
}

std::string Mission::stoppedReason(Stamp now) const {
  if (!hearsLocalPlanner(now))
    return isCamera() ? "planner stopped: no path from it" : "avoidance stopped: no command from it";
  if (isCamera()) return "";
  if (local_->status == MotionCommand::Status::kStopped) return "avoidance stopped: " + local_->reason;
  const bool had_time = toSeconds(local_->stamp - goal_start_) > params_.input_timeout_s;
  if (local_->status == MotionCommand::Status::kIdle && had_time)
    return "avoidance stopped: it has not heard of the goal";
  return "";
}

// What stands in the way now; empty when the way is open.
std::string Mission::obstruction(Stamp now) {
  std::string reason;
  if (params_.needs_path && path_ && path_->stamp >= goal_start_ && !path_->found)
    reason = "no path to the goal: " + (path_->reason.empty() ? "every way is closed" : path_->reason);
  else if (!isCamera() && local_ && local_->stamp >= goal_start_ &&
           local_->status == MotionCommand::Status::kBlocked)
    reason = "blocked: " + (local_->reason.empty() ? "no way past the obstacles" : local_->reason);
  if (reason.empty()) {
    obstructed_since_.reset();
  } else if (!obstructed_since_) {
    obstructed_since_ = now;
  }
  return reason;
}

}  // namespace frugal_nav
