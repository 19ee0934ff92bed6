#pragma once

#include <chrono>
#include <optional>

#include <ros/duration.h>

#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// Holds simulated time to a multiple of wall time. What a slow machine loses is not caught up with.
class SimulatorPacer {
 public:
  /// 1 is real time; 0 is as fast as possible.
  explicit SimulatorPacer(double real_time_factor) : real_time_factor_(real_time_factor) {}

  /// Wall time until the next step is due; zero when it is.
  ros::WallDuration untilDue() const;
  /// The simulation went on by this much.
  void advanced(Duration simulated);
  /// Starts anew, after a pause.
  void restart() { due_.reset(); }

 private:
  using Clock = std::chrono::steady_clock;

  double real_time_factor_;
  std::optional<Clock::time_point> due_;
};

}  // namespace frugal_nav
