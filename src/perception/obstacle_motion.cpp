#include "detector_support.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <frugal_nav/perception/obstacle_motion.hpp>

namespace frugal_nav {
namespace {

SeenObstacle measure(int first, int last, const std::vector<ColumnSurface>& surfaces, double nearest_share) {
  SeenObstacle seen;
  seen.first_column = first;
  seen.last_column = last;
  seen.is_cut_off = first == 0 || last == static_cast<int>(surfaces.size()) - 1;
  std::vector<int> columns;
  for (int column = first; column <= last; ++column) {
    columns.push_back(column);
    seen.middle_base += surfaces[static_cast<std::size_t>(column)].p_base.cast<double>();
  }
  seen.middle_base /= static_cast<double>(columns.size());
  const auto rank = static_cast<std::ptrdiff_t>(nearest_share * static_cast<double>(columns.size()));
  std::nth_element(columns.begin(), columns.begin() + rank, columns.end(), [&](int a, int b) {
    return surfaces[static_cast<std::size_t>(a)].p_base.squaredNorm() <
           surfaces[static_cast<std::size_t>(b)].p_base.squaredNorm();
  });
  seen.nearest_column = columns[static_cast<std::size_t>(rank)];
  seen.p_base = surfaces[static_cast<std::size_t>(seen.nearest_column)].p_base.cast<double>();
  seen.distance_m = seen.p_base.norm();
  return seen;
}

}  // namespace

std::vector<SeenObstacle> joinColumns(const std::vector<ColumnSurface>& surfaces,
                                      const std::optional<Eigen::Vector2d>& p_base_goal,
                                      const ObstacleMotionParams& params) {
  const auto counts = [&](const ColumnSurface& surface) {
    if (surface.state != ColumnSurface::State::kHit) return false;
    return !p_base_goal || (surface.p_base.cast<double>() - *p_base_goal).norm() > params.goal_radius_m;
  };
  std::vector<SeenObstacle> all;
  const int count = static_cast<int>(surfaces.size());
  for (int first = 0; first < count;) {
    if (!counts(surfaces[static_cast<std::size_t>(first)])) {
      ++first;
      continue;
    }
    int last = first;
    while (last + 1 < count && counts(surfaces[static_cast<std::size_t>(last) + 1]) &&
           (surfaces[static_cast<std::size_t>(last) + 1].p_base -
            surfaces[static_cast<std::size_t>(last)].p_base)
                   .norm() < static_cast<float>(params.join_m)) {
      ++last;
    }
    all.push_back(measure(first, last, surfaces, params.nearest_share));
    first = last + 1;
  }
  std::sort(all.begin(), all.end(),
            [](const SeenObstacle& a, const SeenObstacle& b) { return a.distance_m < b.distance_m; });
  const auto is_wide = [&](const SeenObstacle& seen) {
    return seen.last_column - seen.first_column + 1 >= params.min_columns;
  };
  if (std::any_of(all.begin(), all.end(), is_wide))
    all.erase(std::remove_if(all.begin(), all.end(), [&](const SeenObstacle& s) { return !is_wide(s); }),
              all.end());
  return all;
}

ObstacleMotion::ObstacleMotion(const ObstacleMotionParams& params)
    : params_(validated(params, "obstacle motion")) {}

ObstacleMotion::Track ObstacleMotion::begin(Stamp stamp, const Eigen::Vector2d& p_odom) const {
  Track track;
  track.born = track.seen = track.stamp = stamp;
  track.state << p_odom, 0.0, 0.0;
  const double p = params_.position_sigma_m;
  track.covariance = Eigen::Vector4d(p * p, p * p, 1.0, 1.0).asDiagonal();  // people walk at 1 m/s
  return track;
}

void ObstacleMotion::predict(Stamp stamp, Track& track) const {
  const double t = toSeconds(stamp - track.stamp);
  Eigen::Matrix4d f = Eigen::Matrix4d::Identity();
  f(0, 2) = f(1, 3) = t;
  // White acceleration over the step (Bar-Shalom, Estimation with Applications, 6.3.2).
  Eigen::Matrix<double, 4, 2> g;
  g << 0.5 * t * t, 0.0, 0.0, 0.5 * t * t, t, 0.0, 0.0, t;
  track.state = (f * track.state).eval();
  track.covariance = (f * track.covariance * f.transpose() +
                      params_.acceleration_mps2 * params_.acceleration_mps2 * g * g.transpose())
                         .eval();
  track.stamp = stamp;
}

void ObstacleMotion::correct(const Eigen::Vector2d& p_odom, Stamp stamp, Track& track) const {
  const double variance = params_.position_sigma_m * params_.position_sigma_m;
  const Eigen::Matrix2d spread =
      track.covariance.topLeftCorner<2, 2>() + variance * Eigen::Matrix2d::Identity();
  const Eigen::Matrix<double, 4, 2> gain = track.covariance.leftCols<2>() * spread.inverse();
  track.state += gain * (p_odom - track.state.head<2>());
  track.covariance -= (gain * track.covariance.topRows<2>()).eval();
  track.seen = stamp;
}

Eigen::Vector2d ObstacleMotion::velocityOf(const Track& track) const {
  const Eigen::Vector2d velocity = track.state.tail<2>();
  const double speed = velocity.norm();
  if (toSeconds(track.seen - track.born) < params_.min_age_s || speed < params_.min_speed_mps ||
      speed > params_.max_speed_mps)
    return Eigen::Vector2d::Zero();
  const double squared = velocity.dot(track.covariance.bottomRightCorner<2, 2>().inverse() * velocity);
  return squared > params_.moving_sigma * params_.moving_sigma ? velocity : Eigen::Vector2d::Zero().eval();
}

std::vector<Eigen::Vector2d> ObstacleMotion::update(Stamp stamp, const Pose2& odom_from_base,
                                                    const std::vector<SeenObstacle>& seen) {
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(),
                               [&](const Track& t) { return toSeconds(stamp - t.seen) > params_.forget_s; }),
                tracks_.end());
  for (Track& track : tracks_) predict(stamp, track);
  std::vector<bool> taken(tracks_.size(), false);
  std::vector<Eigen::Vector2d> velocities;
  for (const SeenObstacle& obstacle : seen) {
    const Eigen::Vector2d p_odom = odom_from_base * obstacle.middle_base;
    std::size_t best = taken.size();
    double nearest = params_.gate_m;
    for (std::size_t i = 0; i < taken.size(); ++i) {
      const double off = (tracks_[i].state.head<2>() - p_odom).norm();
      if (!taken[i] && off < nearest) {
        nearest = off;
        best = i;
      }
    }
    if (best == taken.size()) {
      tracks_.push_back(begin(stamp, p_odom));
      velocities.emplace_back(Eigen::Vector2d::Zero());
      continue;
    }
    taken[best] = true;
    Track& track = tracks_[best];
    if (obstacle.is_cut_off) {  // what is seen of it changes as it enters or leaves the view
      track = begin(stamp, p_odom);
    } else {
      correct(p_odom, stamp, track);
    }
    velocities.push_back(velocityOf(track));
  }
  return velocities;
}

}  // namespace frugal_nav
