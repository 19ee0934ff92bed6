#include <algorithm>

#include <frugal_nav/ros/simulator_pacer.hpp>

namespace frugal_nav {
namespace {

// Up to this much is caught up with: it evens out the scheduler's jitter.
constexpr std::chrono::milliseconds kLongestLag{100};

}  // namespace

ros::WallDuration SimulatorPacer::untilDue() const {
  if (real_time_factor_ <= 0.0 || !due_) return ros::WallDuration(0.0);
  const std::chrono::duration<double> wait = *due_ - Clock::now();
  return ros::WallDuration(std::max(0.0, wait.count()));
}

void SimulatorPacer::advanced(Duration simulated) {
  if (real_time_factor_ <= 0.0) return;
  const Clock::time_point now = Clock::now();
  const Clock::time_point from = due_ ? std::max(*due_, now - kLongestLag) : now;
  due_ = from + std::chrono::duration_cast<Clock::duration>(
                    std::chrono::duration<double>(toSeconds(simulated) / real_time_factor_));
}

}  // namespace frugal_nav
