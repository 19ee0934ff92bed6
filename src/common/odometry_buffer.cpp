#include <algorithm>

#include <frugal_nav/common/odometry_buffer.hpp>

namespace frugal_nav {

OdometryBuffer::Added OdometryBuffer::add(const Odometry& odometry) {
  Added added = Added::kAdded;
  if (!buffer_.empty()) {
    if (odometry.stamp == newest().stamp) return Added::kDuplicate;
    if (odometry.stamp < newest().stamp) {
      buffer_.clear();
      added = Added::kJumpedBack;
    }
  }
  buffer_.push_back(odometry);
  while (buffer_.front().stamp < odometry.stamp - span_) buffer_.pop_front();
  return added;
}

bool OdometryBuffer::covers(Stamp stamp) const {
  return !buffer_.empty() && buffer_.front().stamp <= stamp && stamp <= newest().stamp;
}

std::optional<Odometry> OdometryBuffer::at(Stamp stamp) const {
  if (!covers(stamp)) return std::nullopt;
  const auto after = std::lower_bound(buffer_.begin(), buffer_.end(), stamp,
                                      [](const Odometry& odometry, Stamp t) { return odometry.stamp < t; });
  if (after->stamp == stamp) return *after;
  const Odometry& before = *(after - 1);
  const double fraction = toSeconds(stamp - before.stamp) / toSeconds(after->stamp - before.stamp);
  Odometry between = *after;  // the later, larger covariance
  between.stamp = stamp;
  between.odom_from_base = interpolate(before.odom_from_base, after->odom_from_base, fraction);
  between.twist.v_mps = before.twist.v_mps + fraction * (after->twist.v_mps - before.twist.v_mps);
  between.twist.w_radps = before.twist.w_radps + fraction * (after->twist.w_radps - before.twist.w_radps);
  return between;
}

std::optional<Odometry> OdometryBuffer::predictedAt(Stamp stamp) const {
  if (buffer_.empty() || stamp <= newest().stamp) return at(stamp);
  Odometry predicted = newest();
  predicted.odom_from_base =
      predicted.odom_from_base * arcMotion(predicted.twist, toSeconds(stamp - predicted.stamp));
  predicted.stamp = stamp;
  return predicted;
}

}  // namespace frugal_nav
