#pragma once

#include <chrono>
#include <cstdint>

namespace frugal_nav {

/// The clock of every stamp: ROS time, handed in from outside. It has no now(): the core never reads a clock.
struct RosClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<RosClock>;
  static constexpr bool is_steady = false;
};

/// Integer-nanosecond instant in ROS time.
using Stamp = RosClock::time_point;
/// Integer-nanosecond time span.
using Duration = RosClock::duration;

/// Time span from seconds, rounded to the nearest nanosecond.
constexpr Duration fromSeconds(double seconds) {
  return Duration(static_cast<std::int64_t>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5)));
}

/// Instant from seconds since the epoch of ROS time.
constexpr Stamp stampFromSeconds(double seconds) { return Stamp(fromSeconds(seconds)); }

/// Time span in seconds.
constexpr double toSeconds(Duration duration) { return static_cast<double>(duration.count()) * 1e-9; }

/// Instant in seconds since the epoch of ROS time.
constexpr double toSeconds(Stamp stamp) { return toSeconds(stamp.time_since_epoch()); }

}  // namespace frugal_nav
