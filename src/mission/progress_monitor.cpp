#include <cmath>

#include <frugal_nav/mission/progress_monitor.hpp>

namespace frugal_nav {

void ProgressMonitor::start(Stamp stamp) {
  resume(stamp);
  reroutes_ = 0;
}

void ProgressMonitor::resume(Stamp stamp) {
  last_progress_ = stamp;
  best_m_.reset();
  anchor_.reset();
}

void ProgressMonitor::wait(Stamp stamp) { last_progress_ = stamp; }

ProgressMonitor::Verdict ProgressMonitor::update(const Sample& sample) {
  if (sample.remaining_m) follow(sample.stamp, *sample.remaining_m);
  if (stalled(sample)) return Verdict::kStalled;
  return withoutProgress_s(sample.stamp) >= params_.stuck_s ? Verdict::kNoProgress : Verdict::kMoving;
}

void ProgressMonitor::follow(Stamp stamp, double remaining_m) {
  if (!best_m_) {
    best_m_ = first_m_ = remaining_m;
  } else if (remaining_m <= *best_m_ - params_.step_m) {
    best_m_ = remaining_m;
    last_progress_ = stamp;
  } else if (remaining_m >= previous_m_ + params_.reroute_m && reroutes_ < params_.max_reroutes) {
    ++reroutes_;
    first_m_ += remaining_m - *best_m_;  // a detour is neither gain nor loss
    best_m_ = remaining_m;
    last_progress_ = stamp;
  }
  previous_m_ = remaining_m;
}

bool ProgressMonitor::stalled(const Sample& sample) {
  if (!sample.commanded) {
    anchor_.reset();
    return false;
  }
  const bool moved = anchor_ && (distance(anchor_->odom_from_base, sample.odom_from_base) > params_.stall_m ||
                                 std::abs(angleBetween(anchor_->odom_from_base.yaw_rad,
                                                       sample.odom_from_base.yaw_rad)) > params_.stall_rad);
  if (!anchor_ || moved) anchor_ = sample;
  return toSeconds(sample.stamp - anchor_->stamp) >= params_.stall_s;
}

}  // namespace frugal_nav
