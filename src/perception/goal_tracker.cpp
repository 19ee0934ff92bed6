#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <frugal_nav/perception/goal_tracker.hpp>

namespace frugal_nav {
namespace {

constexpr int kSize = 3;  // index of the head's size in the state

bool isUsable(const HeadSighting& sighting) {
  return sighting.status == HeadSighting::Status::kGood && sighting.p_base.allFinite() &&
         sighting.from_eye_m.allFinite() && sighting.noise_m2.allFinite() &&
         sighting.noise_m2.determinant() > 0.0;
}

/// Kalman's step in Joseph's form, which stays symmetric and positive.
template <int kRows>
void correct(const Eigen::Matrix<double, kRows, 4>& by_state, const Eigen::Matrix<double, kRows, 1>& off,
             const Eigen::Matrix<double, kRows, kRows>& noise, Eigen::Vector4d& state,
             Eigen::Matrix4d& covariance) {
  const Eigen::Matrix<double, kRows, kRows> spread = by_state * covariance * by_state.transpose() + noise;
  const Eigen::Matrix<double, 4, kRows> gain = covariance * by_state.transpose() * spread.inverse();
  const Eigen::Matrix4d rest = Eigen::Matrix4d::Identity() - gain * by_state;
  state += gain * off;
  covariance = rest * covariance * rest.transpose() + gain * noise * gain.transpose();
}

}  // namespace

/// How a sighting differs from what a track lets expect.
struct GoalTracker::Innovation {
  Eigen::Vector3d off;
  Eigen::Matrix3d noise;
  Eigen::Matrix<double, 3, 4> by_state;
  double sigmas = 0.0;
};

GoalTracker::GoalTracker(const GoalTrackerParams& params) : params_(params) {
  validate(params, "goal tracker");
}

void GoalTracker::reset() {
  state_ = State::kNone;
  last_stamp_.reset();
  goal_.reset();
  candidate_.reset();
  seen_by_.reset();
}

GoalTracker::State GoalTracker::update(Stamp stamp, const Pose2& odom_from_base,
                                       const std::vector<HeadSighting>& sightings, bool could_see) {
  if (last_stamp_ && stamp < *last_stamp_) reset();
  if (last_stamp_ && stamp == *last_stamp_) return state_;
  last_stamp_ = stamp;
  seen_by_.reset();
  std::vector<Seen> seen;
  const Eigen::Isometry3d to_odom = toIsometry(odom_from_base);
  const Eigen::Matrix3d turn = to_odom.linear();
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const HeadSighting& sighting = sightings[i];
    if (!isUsable(sighting) || !odom_from_base.isFinite()) continue;
    const Eigen::Vector3d p_base(sighting.p_base.x(), sighting.p_base.y(), sighting.above_floor_m);
    seen.push_back({&sighting, i, to_odom * p_base, turn * sighting.from_eye_m,
                    turn * sighting.noise_m2 * turn.transpose()});
  }
  predict(goal_, stamp);
  predict(candidate_, stamp);
  if (goal_) updateGoal(stamp, seen, could_see);
  updateCandidate(stamp, seen);
  return state_;
}

void GoalTracker::predict(std::optional<Track>& track, Stamp stamp) const {
  if (!track) return;
  const double since_s = toSeconds(stamp - track->stamp);
  track->covariance.topLeftCorner<2, 2>() += params_.drift_m2ps * since_s * Eigen::Matrix2d::Identity();
  track->stamp = stamp;
}

GoalTracker::Track GoalTracker::trackOf(const Seen& seen, Stamp stamp) const {
  Track track;
  track.stamp = track.since = track.goal.last_seen = stamp;
  track.goal.class_id = seen.sighting->class_id;
  track.goal.score = seen.sighting->score;
  track.goal.sightings = 1;
  track.state << seen.p_odom, 1.0;
  const double size_variance = seen.sighting->size_sigma * seen.sighting->size_sigma;
  track.covariance.topLeftCorner<3, 3>() =
      seen.noise_m2 + size_variance * seen.from_eye * seen.from_eye.transpose();
  track.covariance.topRightCorner<3, 1>() = size_variance * seen.from_eye;
  track.covariance.bottomLeftCorner<1, 3>() = size_variance * seen.from_eye.transpose();
  track.covariance(kSize, kSize) = size_variance;
  return track;
}

/// A head of `size` times the assumed one seems to stand at 1 / size of its distance from the eye.
GoalTracker::Innovation GoalTracker::compare(const Track& track, const Seen& seen, Stamp stamp) const {
  const Eigen::Vector3d eye = seen.p_odom - seen.from_eye;
  const double size = track.state[kSize];
  const Eigen::Vector3d from_eye = track.state.head<3>() - eye;
  const double since_s = toSeconds(stamp - track.goal.last_seen);
  Innovation innovation;
  innovation.off = seen.from_eye - from_eye / size;
  innovation.noise = seen.noise_m2 * std::max(1.0, params_.alike_s / std::max(since_s, 1e-3));
  innovation.by_state << Eigen::Matrix3d::Identity() / size, -from_eye / (size * size);
  const Eigen::Matrix3d spread =
      innovation.by_state * track.covariance * innovation.by_state.transpose() + innovation.noise;
  innovation.sigmas = std::sqrt(innovation.off.dot(spread.inverse() * innovation.off));
  return innovation;
}

GoalTracker::Seen* GoalTracker::nearest(const Track& track, std::vector<Seen>& seen, double min_score,
                                        Stamp stamp) const {
  Seen* best = nullptr;
  double best_sigmas = params_.gate_sigma;
  for (Seen& candidate : seen) {
    const HeadSighting* sighting = candidate.sighting;
    if (sighting == nullptr || sighting->score < min_score || sighting->class_id != track.goal.class_id)
      continue;
    const double sigmas = compare(track, candidate, stamp).sigmas;
    if (!(sigmas < best_sigmas)) continue;
    best = &candidate;
    best_sigmas = sigmas;
  }
  return best;
}

void GoalTracker::absorb(Track& track, const Seen& seen, Stamp stamp) const {
  const Innovation innovation = compare(track, seen, stamp);
  correct<3>(innovation.by_state, innovation.off, innovation.noise, track.state, track.covariance);
  ++track.goal.sightings;
  track.goal.score = seen.sighting->score;
  track.goal.last_seen = stamp;
}

void GoalTracker::updateGoal(Stamp stamp, std::vector<Seen>& seen, bool could_see) {
  // Where it is out of view a weak sighting is something else: a shadow, a hand.
  Seen* own = nearest(*goal_, seen, could_see ? params_.keep_score : params_.start_score, stamp);
  if (own != nullptr) {
    absorb(*goal_, *own, stamp);
    own->sighting = nullptr;  // taken
    seen_by_ = own->index;
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
  if (candidate_ && toSeconds(stamp - candidate_->goal.last_seen) > params_.confirm_within_s)
    candidate_.reset();
  Seen* own = candidate_ ? nearest(*candidate_, seen, params_.start_score, stamp) : nullptr;
  if (own != nullptr) {
    absorb(*candidate_, *own, stamp);
  } else if (!candidate_) {
    const auto score = [](const Seen& s) { return s.sighting == nullptr ? -1.0 : s.sighting->score; };
    const auto best = std::max_element(seen.begin(), seen.end(),
                                       [&](const Seen& a, const Seen& b) { return score(a) < score(b); });
    if (best == seen.end() || score(*best) < params_.start_score) return;
    own = &*best;
    candidate_ = trackOf(*own, stamp);
  }
  if (own == nullptr || !replacesGoal(*candidate_, stamp)) return;
  goal_ = candidate_;
  candidate_.reset();
  last_excused_ = stamp;
  state_ = State::kSeen;
  seen_by_ = own->index;
}

/// Whether a candidate has stood long enough to be the goal, and the goal there may be has been missing where
/// it was for as long: out of view it may still be there, and what seems to stand beside it be its shadow.
bool GoalTracker::replacesGoal(const Track& candidate, Stamp stamp) const {
  if (candidate.goal.sightings < params_.confirm_sightings ||
      toSeconds(stamp - candidate.since) < params_.stand_s)
    return false;
  if (!goal_) return true;
  return toSeconds(stamp - last_excused_) >= params_.stand_s && goal_->goal.last_seen < candidate.since &&
         (goal_->state - candidate.state).head<2>().norm() <= params_.shift_m;
}

bool GoalTracker::place(Stamp stamp, const Eigen::Vector2d& p_odom, const Eigen::Matrix2d& covariance_m2) {
  if (!goal_) return false;
  const double since_s = std::max(toSeconds(stamp - goal_->placed), 1e-3);
  const Eigen::Matrix2d noise = covariance_m2 * std::max(1.0, params_.alike_s / since_s);
  const Eigen::Vector2d off = p_odom - goal_->state.head<2>();
  const Eigen::Matrix2d spread = goal_->covariance.topLeftCorner<2, 2>() + noise;
  if (off.dot(spread.inverse() * off) > params_.gate_sigma * params_.gate_sigma) return false;
  correct<2>(Eigen::Matrix<double, 2, 4>::Identity(), off, noise, goal_->state, goal_->covariance);
  goal_->placed = stamp;
  return true;
}

std::optional<TrackedGoal> GoalTracker::goal() const {
  if (!goal_) return std::nullopt;
  TrackedGoal goal = goal_->goal;
  goal.stamp = goal_->stamp;
  goal.p_odom = goal_->state.head<2>();
  goal.above_floor_m = goal_->state[2];
  goal.covariance_m2 = goal_->covariance.topLeftCorner<2, 2>();
  return goal;
}

}  // namespace frugal_nav
