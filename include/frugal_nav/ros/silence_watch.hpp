#pragma once

#include <ros/time.h>

namespace frugal_nav {

/// Tells when a sensor has not been heard of for a while of ROS time. The time counts from when the clock
/// begins, in simulation after the nodes, and anew when it jumps back.
class SilenceWatch {
 public:
  void heard(ros::Time now) { last_ = now; }
  bool isSilent(ros::Time now, double after_s) {
    if (last_.isZero() || now < last_) last_ = now;
    return (now - last_).toSec() > after_s;
  }

 private:
  ros::Time last_;
};

}  // namespace frugal_nav
