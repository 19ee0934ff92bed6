#pragma once

#include <functional>
#include <map>
#include <string>

#include <ros/time.h>

#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// Tells once when time jumps back: a stamp of an input that is older than the input's last, or ROS time
/// itself. Clock and messages come on different connections, so that one jump shows in both, in either order.
class TimeJumpWatch {
 public:
  /// `jumped` gets the first instant of the new time. `slack` is how far a stamp may go back, or lie ahead of
  /// ROS time, and be the node's own to judge: for one that puts late messages in their places. Without it
  /// each step back is a jump.
  explicit TimeJumpWatch(std::function<void(Stamp now)> jumped, Duration slack = {})
      : jumped_(std::move(jumped)), slack_(slack) {}

  /// Checks the stamp of an input's message, before it is used. A message without a stamp tells nothing.
  void checkStamp(const std::string& input, Stamp stamp);
  /// Checks ROS time; to be called now and then, and before a message without a stamp of its own is used.
  void checkClock();

 private:
  void tell(const std::string& who, Stamp now);

  std::function<void(Stamp now)> jumped_;
  Duration slack_;
  std::map<std::string, Stamp> last_stamps_;
  ros::Time last_now_;
  ros::Time stamps_jumped_;  // when, in the old time, they did; ROS time may yet follow: the same jump
};

}  // namespace frugal_nav
