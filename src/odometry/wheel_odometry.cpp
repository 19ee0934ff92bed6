#include <algorithm>
#include <cmath>
#include <limits>

#include <frugal_nav/odometry/wheel_odometry.hpp>

namespace frugal_nav {
namespace {

constexpr double kLongestGap_s = 0.5;

/// The signed count between two readings of a counter of `bits` bits, which may have rolled over between
/// them.
std::int64_t countBetween(std::int64_t from, std::int64_t to, int bits) {
  const std::uint64_t difference = static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from);
  if (bits == 16) return static_cast<std::int16_t>(difference);
  if (bits == 32) return static_cast<std::int32_t>(difference);
  return static_cast<std::int64_t>(difference);
}

}  // namespace

std::string WheelOdometryParams::check() const {
  if (tick_bits != 16 && tick_bits != 32 && tick_bits != 64) {
    return "tick_bits = " + std::to_string(tick_bits) + " is none of 16, 32, 64";
  }
  return {};
}

ArcStep arcStep(double yaw_rad, double left_m, double right_m, double separation_m) {
  const double length = 0.5 * (left_m + right_m);
  const double turn = (right_m - left_m) / separation_m;
  const double half = 0.5 * turn;
  // Chord over arc length, sin(h)/h, and its derivative by h; series near zero, where the quotients lose
  // digits.
  const bool straight = std::abs(half) < 1e-4;
  const double ratio = straight ? 1.0 - half * half / 6.0 : std::sin(half) / half;
  const double ratio_by_half = straight ? -half / 3.0 : (std::cos(half) - ratio) / half;
  const Eigen::Vector2d along(std::cos(yaw_rad + half), std::sin(yaw_rad + half));
  const Eigen::Vector2d aside(-along.y(), along.x());
  const Eigen::Vector2d displacement = length * ratio * along;

  ArcStep step;
  step.motion = {length * ratio * std::cos(half), length * ratio * std::sin(half), turn};
  step.by_pose = Eigen::Matrix3d::Identity();
  step.by_pose(0, 2) = -displacement.y();
  step.by_pose(1, 2) = displacement.x();
  Eigen::Matrix<double, 3, 2> by_length_turn;
  by_length_turn.col(0) << ratio * along, 0.0;
  by_length_turn.col(1) << 0.5 * length * (ratio_by_half * along + ratio * aside), 1.0;
  Eigen::Matrix2d length_turn_by_wheel;
  length_turn_by_wheel << 0.5, 0.5, -1.0 / separation_m, 1.0 / separation_m;
  step.by_wheel = by_length_turn * length_turn_by_wheel;
  return step;
}

WheelOdometry::WheelOdometry(const WheelOdometryParams& params, const WheelGeometry& geometry)
    : geometry_(geometry) {
  if (!(geometry.radius_m > 0.0) || !(geometry.separation_m > 0.0)) {
    throw ConfigError(
        "wheel odometry: wheel radius and separation must be positive: check the wheels of the URDF");
  }
  setParams(params);
  restart({params.start_x_m, params.start_y_m, params.start_yaw_rad});
}

void WheelOdometry::setParams(const WheelOdometryParams& params) {
  validate(params, "wheel odometry");
  params_ = params;
}

void WheelOdometry::restart(const Pose2& odom_from_base) {
  odometry_ = {};
  odometry_.odom_from_base = odom_from_base;
  last_.reset();
  window_.clear();
}

std::optional<Odometry> WheelOdometry::addTicks(Stamp stamp, std::int64_t left, std::int64_t right) {
  return add(stamp, {left, right, 0.0, 0.0}, true);
}

std::optional<Odometry> WheelOdometry::addAngles(Stamp stamp, double left_rad, double right_rad) {
  if (!std::isfinite(left_rad) || !std::isfinite(right_rad)) {
    ++counts_.refused;
    return std::nullopt;
  }
  return add(stamp, {0, 0, left_rad, right_rad}, false);
}

std::optional<Odometry> WheelOdometry::add(Stamp stamp, const Reading& reading, bool is_ticks) {
  if (last_ && stamp == odometry_.stamp) {
    ++counts_.duplicates;
    return std::nullopt;
  }
  if (last_ && stamp < odometry_.stamp) {
    ++counts_.restarts;
    restart({params_.start_x_m, params_.start_y_m, params_.start_yaw_rad});
  }
  ++counts_.readings;
  if (last_) {
    const Turn turn = turnSince(reading, is_ticks);
    const double elapsed_s = toSeconds(stamp - odometry_.stamp);
    if (isPlausible(turn, elapsed_s, is_ticks)) {
      left_angle_rad_ += turn.left_rad;
      right_angle_rad_ += turn.right_rad;
      advance(leftRadius_m() * turn.left_rad, rightRadius_m() * turn.right_rad);
    } else {
      ++counts_.rebased;
      // What was rolled meanwhile is unseen: about what the present velocity makes of the time.
      const Pose2 unseen = arcMotion(odometry_.twist, elapsed_s);
      odometry_.pose_covariance.diagonal() += Eigen::Vector3d(
          unseen.position().squaredNorm(), unseen.position().squaredNorm(), unseen.yaw_rad * unseen.yaw_rad);
      window_.clear();
    }
  }
  last_ = reading;
  odometry_.stamp = stamp;
  const double resolution_m = is_ticks ? 2.0 * M_PI * geometry_.radius_m / params_.ticks_per_revolution : 0.0;
  updateVelocity(stamp, resolution_m);
  return odometry_;
}

WheelOdometry::Turn WheelOdometry::turnSince(const Reading& reading, bool is_ticks) const {
  if (!is_ticks) return {reading.left_rad - last_->left_rad, reading.right_rad - last_->right_rad};
  const double rad_per_tick = 2.0 * M_PI / params_.ticks_per_revolution;
  const auto left = countBetween(last_->left_ticks, reading.left_ticks, params_.tick_bits);
  const auto right = countBetween(last_->right_ticks, reading.right_ticks, params_.tick_bits);
  return {rad_per_tick * static_cast<double>(left), rad_per_tick * static_cast<double>(right)};
}

bool WheelOdometry::isPlausible(const Turn& turn, double elapsed_s, bool is_ticks) const {
  const double rad_per_tick = is_ticks ? 2.0 * M_PI / params_.ticks_per_revolution : 0.0;
  // Half of the counter's range is the most that can be told from a roll-over the other way.
  const double range_rad = is_ticks ? rad_per_tick * std::ldexp(1.0, params_.tick_bits - 1)
                                    : std::numeric_limits<double>::infinity();
  if (params_.max_wheel_speed_mps * elapsed_s > geometry_.radius_m * range_rad) return false;
  // After a long gap a restarted counter would pass for motion: no more than that of a short one is believed.
  const double most_m = params_.max_wheel_speed_mps * std::min(elapsed_s, kLongestGap_s);
  const double most_rad = most_m / geometry_.radius_m + rad_per_tick;
  return std::abs(turn.left_rad) <= most_rad && std::abs(turn.right_rad) <= most_rad;
}

void WheelOdometry::advance(double left_m, double right_m) {
  const ArcStep step = arcStep(odometry_.odom_from_base.yaw_rad, left_m, right_m, separation_m());
  odometry_.odom_from_base = odometry_.odom_from_base * step.motion;
  // The random-walk model of Chong & Kleeman (1997): a wheel's variance grows with the distance it rolls.
  const Eigen::Vector2d wheel_variance =
      params_.distance_noise_m * Eigen::Vector2d(std::abs(left_m), std::abs(right_m));
  odometry_.pose_covariance = step.by_pose * odometry_.pose_covariance * step.by_pose.transpose() +
                              step.by_wheel * wheel_variance.asDiagonal() * step.by_wheel.transpose();
  rolled_.left_m += left_m;
  rolled_.right_m += right_m;
}

void WheelOdometry::updateVelocity(Stamp stamp, double resolution_m) {
  rolled_.stamp = stamp;
  window_.push_back(rolled_);
  const Stamp begin = stamp - fromSeconds(params_.velocity_window_s);
  while (window_.size() > 2 && window_.front().stamp < begin) window_.pop_front();
  if (window_.size() < 2) return;  // the first reading, or the first after a restarted counter

  const double span_s = toSeconds(stamp - window_.front().stamp);
  const double left_m = rolled_.left_m - window_.front().left_m;
  const double right_m = rolled_.right_m - window_.front().right_m;
  const double b = separation_m();
  odometry_.twist = {(left_m + right_m) / (2.0 * span_s), (right_m - left_m) / (b * span_s)};

  // Rolling noise, and counts cut to whole ticks at both ends of the window (a uniform error each, q^2/12).
  const auto variance = [&](double rolled_m) {
    return params_.distance_noise_m * std::abs(rolled_m) + resolution_m * resolution_m / 6.0;
  };
  const double left = variance(left_m) / (span_s * span_s);
  const double right = variance(right_m) / (span_s * span_s);
  constexpr double kFloor = 1e-6;  // (1 mm/s)^2: a filter cannot use a velocity that is certain
  odometry_.twist_covariance << (left + right) / 4.0 + kFloor, (right - left) / (2.0 * b),
      (right - left) / (2.0 * b), (left + right) / (b * b) + kFloor;
}

}  // namespace frugal_nav
