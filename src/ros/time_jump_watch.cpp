#include <algorithm>

#include <ros/console.h>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/time_jump_watch.hpp>

namespace frugal_nav {

void TimeJumpWatch::checkStamp(const std::string& input, Stamp stamp) {
  checkClock();
  const bool is_ahead = slack_ > Duration::zero() && stamp > toStamp(last_now_) + slack_;
  if (stamp == Stamp{} || is_ahead) return;
  const auto last = last_stamps_.find(input);
  if (last != last_stamps_.end() && stamp + slack_ < last->second) {
    tell(input, stamp);
    stamps_jumped_ = last_now_;
  }
  Stamp& newest = last_stamps_[input];
  newest = std::max(newest, stamp);
}

void TimeJumpWatch::checkClock() {
  const ros::Time now = ros::Time::now();
  constexpr double kFollows_s = 1.0;  // or its jump was too small to be seen, and the next is another
  const bool may_follow = !stamps_jumped_.isZero() && (last_now_ - stamps_jumped_).toSec() < kFollows_s;
  if (now < last_now_) {
    if (!may_follow) tell("ROS time", toStamp(now));
    stamps_jumped_ = ros::Time();
  }
  last_now_ = now;
}

void TimeJumpWatch::tell(const std::string& who, Stamp now) {
  ROS_WARN("time jumped back (%s): starting anew", who.c_str());
  last_stamps_.clear();
  jumped_(now);
}

}  // namespace frugal_nav
