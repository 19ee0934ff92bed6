#pragma once

#include <string>

#include <ros/ros.h>
#include <std_msgs/String.h>

namespace frugal_nav {

/// The topic path/reason: why the newest path is empty, since a nav_msgs/Path cannot say it. Latched, and
/// published when it changes; empty while there is a path or no goal.
class PathReason {
 public:
  explicit PathReason(ros::NodeHandle nh)
      : publisher_(nh.advertise<std_msgs::String>("path/reason", 1, true)) {}

  void tell(const std::string& reason) {
    if (reason == last_) return;
    std_msgs::String msg;
    msg.data = last_ = reason;
    publisher_.publish(msg);
  }

 private:
  ros::Publisher publisher_;
  std::string last_;
};

}  // namespace frugal_nav
