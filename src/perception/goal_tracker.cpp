#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include <frugal_nav/perception/goal_tracker.hpp>

namespace frugal_nav {
namespace {

Eigen::Matrix2d rotated(const Eigen::Matrix2d& covariance, double angle_rad) {
  const Eigen::Matrix2d r = Eigen::Rotation2Dd(angle_rad).toRotationMatrix();
  return r * covariance * r.transpose();
}

bool isUsable(const HeadSighting& sighting) {
  return sighting.status == HeadSighting::Status::kGood && sighting.p_base.allFinite() &&
         sighting.noise_m2.allFinite() && sighting.noise_m2.determinant() > 0.0;
}

}  // namespace

GoalTracker::GoalTracker(const GoalTrackerParams& params) : params_(params) {
  validate(params, "goal tracker");
}

void GoalTracker::reset() {
  state_ = State::kNone;
  last_stamp_.reset();
  goal_.reset();
  candidate_.reset();
}

GoalTracker::State GoalTracker::update(Stamp stamp, const Pose2& odom_from_base,
                                       const std::vector<HeadSighting>& sightings, bool could_see) {
  if (last_stamp_ && stamp < *last_stamp_) reset();
  if (last_stamp_ && stamp == *last_stamp_) return state_;
  last_stamp_ = stamp;
  std::vector<Seen> seen;
  for (const HeadSighting& sighting : sightings) {
    if (!isUsable(sighting) || !odom_from_base.isFinite()) continue;
    seen.push_back({&sighting, odom_from_base * sighting.p_base,
                    rotated(sighting.noise_m2, odom_from_base.yaw_rad),
                    rotated(sighting.common_m2, odom_from_base.yaw_rad)});
  }
  if (goal_) updateGoal(stamp, seen, could_see);
  updateCandidate(stamp, seen);
  return state_;
}

GoalTracker::Seen* GoalTracker::nearest(const Track& track, std::vector<Seen>& seen, double min_score) const {
  Seen* best = nullptr;
  double best_distance = std::numeric_limits<double>::infinity();
  for (Seen& candidate : seen) {
    const HeadSighting* sighting = candidate.sighting;
    if (sighting == nullptr || sighting->score < min_score || sighting->class_id != track.goal.class_id)
      continue;
    if (std::abs(sighting->above_floor_m - track.goal.above_floor_m) > params_.height_gate_m) continue;
    const Eigen::Vector2d gap = candidate.p_odom - track.goal.p_odom;
    const Eigen::Matrix2d spread = track.goal.covariance_m2 + candidate.noise_m2 + candidate.common_m2;
    const double sigmas = std::sqrt(gap.dot(spread.inverse() * gap));
    const bool is_near = sigmas <= params_.gate_sigma ||
                         (gap.norm() <= params_.min_gate_m && sighting->score >= params_.start_score);
    if (is_near && sigmas < best_distance) {
      best = &candidate;
      best_distance = sigmas;
    }
  }
  return best;
}

void GoalTracker::absorb(Track& track, const Seen& seen, Stamp stamp) const {
  TrackedGoal& goal = track.goal;
  const Eigen::Vector2d gap = seen.p_odom - goal.p_odom;
  goal.covariance_m2 +=
      params_.drift_m2ps * std::max(0.0, toSeconds(stamp - goal.last_seen)) * Eigen::Matrix2d::Identity();
  const double sigmas = std::sqrt(gap.dot((goal.covariance_m2 + seen.noise_m2).inverse() * gap));
  // Too far off for noise, yet too near for another: the goal has moved, and its old place counts less.
  if (sigmas > params_.gate_sigma) goal.covariance_m2 += gap * gap.transpose();
  const Eigen::Matrix2d gain = goal.covariance_m2 * (goal.covariance_m2 + seen.noise_m2).inverse();
  const Eigen::Matrix2d rest = Eigen::Matrix2d::Identity() - gain;
  goal.p_odom += gain * gap;
  // Joseph's form stays symmetric and positive.
  goal.covariance_m2 = rest * goal.covariance_m2 * rest.transpose() + gain * seen.noise_m2 * gain.transpose();
  ++goal.sightings;
  goal.above_floor_m += (seen.sighting->above_floor_m - goal.above_floor_m) / std::min(goal.sightings, 10);
  goal.score = seen.sighting->score;
  goal.last_seen = stamp;
  track.common_odom_m2 = seen.common_m2;
}

void GoalTracker::updateGoal(Stamp stamp, std::vector<Seen>& seen, bool could_see) {
  // Where it is out of view a weak sighting is something else: a shadow, a hand.
  Seen* own = nearest(*goal_, seen, could_see ? params_.keep_score : params_.start_score);
  if (own != nullptr) {
    absorb(*goal_, *own, stamp);
    own->sighting = nullptr;  // taken
  }
  if (own != nullptr || !could_see) last_excused_ = stamp;
  state_ = own != nullptr ? State::kSeen : State::kUnseen;
  const bool is_missing = toSeconds(stamp - last_excused_) > params_.lost_after_s;
  const bool is_old = toSeconds(stamp - goal_->goal.last_seen) > params_.forget_unseeable_s;
  if (is_missing || is_old) {
    goal_.reset();
    state_ = State::kLost;
  }
}

void GoalTracker::updateCandidate(Stamp stamp, std::vector<Seen>& seen) {
  if (candidate_ && toSeconds(stamp - candidate_->goal.last_seen) > params_.confirm_within_s) {
    candidate_.reset();
  }
  Seen* own = candidate_ ? nearest(*candidate_, seen, params_.start_score) : nullptr;
  if (own != nullptr) {
    absorb(*candidate_, *own, stamp);
  } else if (!candidate_) {
    const auto score = [](const Seen& s) { return s.sighting == nullptr ? -1.0 : s.sighting->score; };
    const auto best = std::max_element(seen.begin(), seen.end(),
                                       [&](const Seen& a, const Seen& b) { return score(a) < score(b); });
    if (best == seen.end() || score(*best) < params_.start_score) return;
    TrackedGoal first;
    first.last_seen = stamp;
    first.class_id = best->sighting->class_id;
    first.score = best->sighting->score;
    first.p_odom = best->p_odom;
    first.covariance_m2 = best->noise_m2;
    first.above_floor_m = best->sighting->above_floor_m;
    first.sightings = 1;
    candidate_ = Track{first, best->common_m2};
  }
  const bool is_confirmed = candidate_ && candidate_->goal.sightings >= params_.confirm_sightings;
  if (!goal_ && is_confirmed && candidate_->goal.last_seen == stamp) {
    goal_ = candidate_;
    candidate_.reset();
    last_excused_ = stamp;
    state_ = State::kSeen;
  }
}

void GoalTracker::doubt(double sigma_m) {
  if (goal_) goal_->goal.covariance_m2 += sigma_m * sigma_m * Eigen::Matrix2d::Identity();
}

bool GoalTracker::place(const Eigen::Vector2d& p_odom, const Eigen::Matrix2d& covariance_m2) {
  if (!goal_) return false;
  TrackedGoal& goal = goal_->goal;
  // It does not depend on the head's size, which all sightings so far had in common.
  const Eigen::Matrix2d prior = goal.covariance_m2 + goal_->common_odom_m2;
  const Eigen::Vector2d gap = p_odom - goal.p_odom;
  const Eigen::Matrix2d inverse = (prior + covariance_m2).inverse();
  if (gap.dot(inverse * gap) > params_.gate_sigma * params_.gate_sigma) return false;
  const Eigen::Matrix2d gain = prior * inverse;
  const Eigen::Matrix2d rest = Eigen::Matrix2d::Identity() - gain;
  goal.p_odom += gain * gap;
  goal.covariance_m2 = rest * prior * rest.transpose() + gain * covariance_m2 * gain.transpose();
  goal_->common_odom_m2.setZero();
  return true;
}

std::optional<TrackedGoal> GoalTracker::goal() const {
  if (!goal_ || !last_stamp_) return std::nullopt;
  TrackedGoal goal = goal_->goal;
  goal.stamp = *last_stamp_;
  goal.covariance_m2 += goal_->common_odom_m2 + params_.drift_m2ps *
                                                    std::max(0.0, toSeconds(goal.stamp - goal.last_seen)) *
                                                    Eigen::Matrix2d::Identity();
  return goal;
}

}  // namespace frugal_nav
