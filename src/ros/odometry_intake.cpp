#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/odometry_intake.hpp>

namespace frugal_nav {

OdometryIntake::OdometryIntake(ros::NodeHandle nh, const IntakeParams& params, NodeDiagnostics& diagnostics,
                               TimeJumpWatch& time, std::function<void()> arrived)
    : params_(params), diagnostics_(diagnostics), time_(time), arrived_(std::move(arrived)) {
  diagnostics_.input("odom");
  subscriber_ =
      nh.subscribe("odom", 50, &OdometryIntake::onOdometry, this, ros::TransportHints().tcpNoDelay());
}

void OdometryIntake::onOdometry(const nav_msgs::Odometry& msg) {
  const std::optional<Odometry> odometry = fromRos(msg);
  if (!odometry) {
    diagnostics_.input("odom").refused("not finite, or no sound quaternion");
    return;
  }
  if (msg.header.frame_id != params_.odom_frame) {
    diagnostics_.input("odom").refused("frame \"" + msg.header.frame_id + "\" instead of \"" +
                                       params_.odom_frame + "\"");
    return;
  }
  time_.checkStamp("odom", odometry->stamp);
  diagnostics_.input("odom").received(odometry->stamp, toStamp(ros::Time::now()));
  buffer_.add(*odometry);
  arrived_();
}

OdometryIntake::Answer OdometryIntake::at(const std::string& what, Stamp stamp, double waited_s) const {
  if (buffer_.covers(stamp)) return {buffer_.at(stamp), ""};
  if (!buffer_.empty() && stamp < buffer_.newest().stamp)
    return {{}, "the " + what + " is older than the odometry kept"};
  if (waited_s > params_.odom_wait_s) return {{}, "no odometry for the " + what + "'s stamp"};
  return {};
}

}  // namespace frugal_nav
