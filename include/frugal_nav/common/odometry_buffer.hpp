#pragma once

#include <deque>
#include <optional>

#include <frugal_nav/common/odometry.hpp>

namespace frugal_nav {

/// The odometry of the last seconds, so that a sensor reading gets the pose of its own stamp.
class OdometryBuffer {
 public:
  enum class Added {
    kAdded,
    kDuplicate,  ///< the newest stamp again: ignored
    kJumpedBack  ///< older than the newest: everything before it was forgotten, then it was added
  };

  explicit OdometryBuffer(Duration span = fromSeconds(3.0)) : span_(span) {}

  /// Keeps one odometry; must be finite.
  Added add(const Odometry& odometry);
  void clear() { buffer_.clear(); }

  bool empty() const { return buffer_.empty(); }
  /// The newest one; must not be empty().
  const Odometry& newest() const { return buffer_.back(); }
  /// True when a stamp lies between the oldest and the newest kept: at() knows it.
  bool covers(Stamp stamp) const;
  /// Pose and velocity at a stamp, between the two around it; nullopt outside what is kept.
  std::optional<Odometry> at(Stamp stamp) const;
  /// The same, but after the newest its velocity goes on along an arc; nullopt before the oldest or when
  /// empty.
  std::optional<Odometry> predictedAt(Stamp stamp) const;

 private:
  Duration span_;
  std::deque<Odometry> buffer_;  // stamps strictly increasing
};

}  // namespace frugal_nav
