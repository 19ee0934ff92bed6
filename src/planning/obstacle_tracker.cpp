#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include <frugal_nav/planning/obstacle_tracker.hpp>

namespace frugal_nav {
namespace {

constexpr std::size_t kLongestTrail = 40;
// Chi-square of two degrees of freedom, 99.7 %: a sighting farther off is another object's.
constexpr double kGate = 11.6;

bool isObject(const LaserScan& scan, std::size_t beam) {
  return classify(scan, scan.ranges_m[beam]) == Return::kHit;
}

/// Whether an object's edge is its own outline: the next beam sees farther, or nothing at all.
bool isOutline(const LaserScan& scan, std::size_t edge, std::size_t next, double jump_m) {
  if (next >= scan.ranges_m.size()) return false;  // cut by the view's edge; below zero wraps here as well
  const Return beyond = classify(scan, scan.ranges_m[next]);
  if (beyond == Return::kTooClose) return false;
  return beyond != Return::kHit || scan.ranges_m[next] > scan.ranges_m[edge] + jump_m;
}

}  // namespace

std::vector<ScanObject> foregroundObjects(const LaserScan& scan, const ObstacleTrackerParams& params) {
  std::vector<ScanObject> objects;
  for (std::size_t i = 0; i < scan.ranges_m.size();) {
    if (!isObject(scan, i)) {
      ++i;
      continue;
    }
    ScanObject object;
    object.first = object.last = i;
    double sum_m = scan.ranges_m[i];
    for (++i; i < scan.ranges_m.size() && isObject(scan, i) &&
              std::abs(scan.ranges_m[i] - scan.ranges_m[i - 1]) < params.jump_m;
         ++i) {
      object.last = i;
      sum_m += scan.ranges_m[i];
    }
    const std::size_t beams = object.last - object.first + 1;
    object.range_m = sum_m / static_cast<double>(beams);
    object.bearing_rad = 0.5 * (scan.angleOf(object.first) + scan.angleOf(object.last));
    object.width_m = object.range_m * static_cast<double>(beams) * std::abs(scan.angle_increment_rad);
    if (beams < 2 || object.range_m > params.max_range_m || object.width_m > params.largest_m) continue;
    if (!isOutline(scan, object.first, object.first - 1, params.jump_m) ||
        !isOutline(scan, object.last, object.last + 1, params.jump_m))
      continue;
    objects.push_back(object);
  }
  return objects;
}

ObstacleTracker::ObstacleTracker(const ObstacleTrackerParams& params) : params_(params) {
  validate(params, "obstacle tracker");
}

void ObstacleTracker::setParams(const ObstacleTrackerParams& params) {
  validate(params, "obstacle tracker");
  params_ = params;
}

std::vector<TrackedObstacle> ObstacleTracker::moving() const {
  std::vector<TrackedObstacle> found;
  std::copy_if(tracks_.begin(), tracks_.end(), std::back_inserter(found),
               [](const TrackedObstacle& track) { return track.moving; });
  return found;
}

void ObstacleTracker::update(const LaserScan& scan, const Pose2& odom_from_base,
                             const std::function<bool(const Eigen::Vector2d&)>& ignore) {
  for (TrackedObstacle& track : tracks_) {
    if (track.moving) track.trail.clear();
    predict(track, scan.stamp);
  }
  std::vector<bool> taken(tracks_.size(), false);
  for (const ScanObject& object : foregroundObjects(scan, params_)) {
    const Eigen::Vector2d ray(std::cos(object.bearing_rad), std::sin(object.bearing_rad));
    const Eigen::Vector2d p_odom = odom_from_base * Eigen::Vector2d(object.range_m * ray);
    if (ignore(p_odom)) continue;
    const double yaw = odom_from_base.yaw_rad + object.bearing_rad;
    const Eigen::Vector2d along(std::cos(yaw), std::sin(yaw));
    const Eigen::Vector2d aside(-along.y(), along.x());
    const double guess_m = object.range_m < params_.near_m ? params_.near_sigma_share * object.range_m : 0.0;
    const double radial_m = params_.sigma_m + params_.range_sigma_share * object.range_m + guess_m;
    const double lateral_m = params_.sigma_m + params_.bearing_sigma_rad * object.range_m + guess_m;
    const Eigen::Matrix2d noise =
        radial_m * radial_m * along * along.transpose() + lateral_m * lateral_m * aside * aside.transpose();
    std::size_t best = tracks_.size();
    double best_distance = kGate;
    for (std::size_t i = 0; i < taken.size(); ++i) {
      if (taken[i]) continue;
      const Eigen::Vector2d off = p_odom - tracks_[i].p_odom;
      const Eigen::Matrix2d spread = tracks_[i].covariance.topLeftCorner<2, 2>() + noise;
      const double distance = off.dot(spread.inverse() * off);
      if (distance < best_distance) {
        best_distance = distance;
        best = i;
      }
    }
    if (best == tracks_.size()) {
      TrackedObstacle track;
      track.id = next_id_++;
      track.p_odom = track.first_p_odom = p_odom;
      track.covariance.setZero();
      track.covariance.topLeftCorner<2, 2>() = noise;
      track.covariance.bottomRightCorner<2, 2>() =
          params_.start_speed_mps * params_.start_speed_mps * Eigen::Matrix2d::Identity();
      tracks_.push_back(track);
      taken.push_back(true);
    } else {
      taken[best] = true;
      tracks_[best].misfit += (best_distance - tracks_[best].misfit) / tracks_[best].sightings;
      correct(tracks_[best], p_odom, noise);
    }
    TrackedObstacle& track = tracks_[best == tracks_.size() ? tracks_.size() - 1 : best];
    track.stamp = track.last_seen = scan.stamp;
    const double radius_m = 0.5 * object.width_m;
    if (track.sightings == 0) track.first_radius_m = track.radius_m = radius_m;
    track.radius_m = 0.7 * track.radius_m + 0.3 * radius_m;
    ++track.sightings;
    judge(track);
    if (track.trail.size() < kLongestTrail) track.trail.push_back(p_odom);
  }
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(),
                               [&](const TrackedObstacle& t) { return isGone(t, scan, odom_from_base); }),
                tracks_.end());
}

void ObstacleTracker::predict(TrackedObstacle& track, Stamp stamp) const {
  const double dt = std::max(toSeconds(stamp - track.stamp), 0.0);
  track.stamp = stamp;
  track.p_odom += dt * track.velocity_mps;
  Eigen::Matrix4d step = Eigen::Matrix4d::Identity();
  step.topRightCorner<2, 2>() = dt * Eigen::Matrix2d::Identity();
  Eigen::Matrix<double, 4, 2> push;  // of an acceleration held for dt
  push << 0.5 * dt * dt * Eigen::Matrix2d::Identity(), dt * Eigen::Matrix2d::Identity();
  track.covariance = step * track.covariance * step.transpose() +
                     params_.acceleration_mps2 * params_.acceleration_mps2 * push * push.transpose();
}

void ObstacleTracker::correct(TrackedObstacle& track, const Eigen::Vector2d& p_odom,
                              const Eigen::Matrix2d& noise) const {
  const Eigen::Matrix2d spread = track.covariance.topLeftCorner<2, 2>() + noise;
  const Eigen::Matrix<double, 4, 2> gain = track.covariance.leftCols<2>() * spread.inverse();
  const Eigen::Vector4d change = gain * (p_odom - track.p_odom);
  track.p_odom += change.head<2>();
  track.velocity_mps += change.tail<2>();
  const Eigen::Matrix4d reduced = track.covariance - gain * track.covariance.topRows<2>();
  track.covariance = 0.5 * (reduced + reduced.transpose());
  const double speed = track.velocity_mps.norm();
  if (speed > params_.fastest_mps) track.velocity_mps *= params_.fastest_mps / speed;
}

void ObstacleTracker::judge(TrackedObstacle& track) const {
  const Eigen::Matrix2d spread = track.covariance.bottomRightCorner<2, 2>();
  const double sigmas = std::sqrt(track.velocity_mps.dot(spread.inverse() * track.velocity_mps));
  const double off_m = std::max(params_.least_way_m, track.first_radius_m + track.radius_m);
  track.moving = track.sightings >= params_.least_sightings && sigmas > params_.significance &&
                 track.velocity_mps.norm() > params_.slowest_mps &&
                 2.0 * track.radius_m > params_.smallest_m && track.misfit < params_.largest_misfit &&
                 (track.p_odom - track.first_p_odom).norm() >= off_m;
}

bool ObstacleTracker::isGone(const TrackedObstacle& track, const LaserScan& scan,
                             const Pose2& odom_from_base) const {
  const double unseen_s = toSeconds(scan.stamp - track.last_seen);
  if (unseen_s <= 0.0) return false;
  if (unseen_s > params_.out_of_view_s) return true;
  const Eigen::Vector2d p_base = odom_from_base.inverse() * track.p_odom;
  const double bearing = std::atan2(p_base.y(), p_base.x());
  const double beam = (bearing - scan.angle_min_rad) / scan.angle_increment_rad;
  const double spare = 0.5 * track.radius_m / std::max(p_base.norm(), 0.1) / scan.angle_increment_rad;
  if (beam < spare || beam > static_cast<double>(scan.ranges_m.size() - 1) - spare) return false;
  const double seen_m = scan.ranges_m[static_cast<std::size_t>(std::lround(beam))];
  const bool hidden = seen_m < p_base.norm() - params_.jump_m;
  return !hidden && unseen_s > params_.unseen_s;
}

}  // namespace frugal_nav
