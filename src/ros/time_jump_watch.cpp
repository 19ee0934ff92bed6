#include <ros/console.h>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/time_jump_watch.hpp>

namespace frugal_nav {

void TimeJumpWatch::checkStamp(const std::string& input, Stamp stamp) {
  checkClock();
  const auto last = last_stamps_.find(input);
  if (last != last_stamps_.end() && stamp < last->second) {
    tell(input, stamp);
    stamps_jumped_ = true;
  }
  last_stamps_[input] = stamp;
}

void TimeJumpWatch::checkClock() {
  const ros::Time now = ros::Time::now();
  if (now < last_now_) {
    if (!stamps_jumped_) tell("ROS time", toStamp(now));
    stamps_jumped_ = false;
  }
  last_now_ = now;
}

void TimeJumpWatch::tell(const std::string& who, Stamp now) {
  ROS_WARN("time jumped back (%s): starting anew", who.c_str());
  last_stamps_.clear();
  jumped_(now);
}

}  // namespace frugal_nav
