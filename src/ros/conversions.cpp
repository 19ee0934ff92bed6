#include <cmath>

#include <frugal_nav/ros/conversions.hpp>

namespace frugal_nav {

Stamp toStamp(const ros::Time& time) {
  return Stamp(Duration(static_cast<std::int64_t>(time.sec) * 1'000'000'000 + time.nsec));
}

ros::Time toRos(Stamp stamp) {
  ros::Time time;
  time.fromNSec(static_cast<std::uint64_t>(stamp.time_since_epoch().count()));
  return time;
}

geometry_msgs::Pose toRos(const Pose2& pose) {
  geometry_msgs::Pose msg;
  msg.position.x = pose.x_m;
  msg.position.y = pose.y_m;
  msg.orientation.z = std::sin(pose.yaw_rad / 2.0);
  msg.orientation.w = std::cos(pose.yaw_rad / 2.0);
  return msg;
}

geometry_msgs::Twist toRos(const Twist2& twist) {
  geometry_msgs::Twist msg;
  msg.linear.x = twist.v_mps;
  msg.angular.z = twist.w_radps;
  return msg;
}

std::optional<double> yawOf(const geometry_msgs::Quaternion& q) {
  const double norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  if (!(std::abs(norm - 1.0) < 0.01)) return std::nullopt;  // catches NaN too
  return std::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
}

std::optional<Pose2> planar(const geometry_msgs::Pose& pose) {
  const std::optional<double> yaw = yawOf(pose.orientation);
  if (!yaw || !std::isfinite(pose.position.x) || !std::isfinite(pose.position.y)) return std::nullopt;
  return Pose2{pose.position.x, pose.position.y, *yaw};
}

Twist2 planar(const geometry_msgs::Twist& twist) { return {twist.linear.x, twist.angular.z}; }

LaserScan fromRos(const sensor_msgs::LaserScan& msg) {
  LaserScan scan;
  scan.stamp = toStamp(msg.header.stamp);
  scan.angle_min_rad = static_cast<double>(msg.angle_min);
  scan.angle_increment_rad = static_cast<double>(msg.angle_increment);
  scan.range_min_m = static_cast<double>(msg.range_min);
  scan.range_max_m = static_cast<double>(msg.range_max);
  scan.ranges_m = msg.ranges;
  return scan;
}

std::optional<Odometry> fromRos(const nav_msgs::Odometry& msg) {
  const std::optional<Pose2> pose = planar(msg.pose.pose);
  const Twist2 twist = planar(msg.twist.twist);
  if (!pose || !twist.isFinite()) return std::nullopt;
  Odometry odometry;
  odometry.stamp = toStamp(msg.header.stamp);
  odometry.odom_from_base = *pose;
  odometry.twist = twist;
  constexpr int kPlanar[] = {0, 1, 5};  // x, y, yaw among (x, y, z, roll, pitch, yaw)
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      odometry.pose_covariance(row, column) =
          msg.pose.covariance[static_cast<std::size_t>(6 * kPlanar[row] + kPlanar[column])];
    }
  }
  odometry.twist_covariance << msg.twist.covariance[0], msg.twist.covariance[5], msg.twist.covariance[30],
      msg.twist.covariance[35];
  return odometry;
}

nav_msgs::Odometry toRos(const Odometry& odometry, const std::string& odom_frame,
                         const std::string& base_frame) {
  constexpr double kPlaneVariance =
      1e-6;  // z, roll, pitch and sideways speed: zero, as sure as a filter likes it
  nav_msgs::Odometry msg;
  msg.header.stamp = toRos(odometry.stamp);
  msg.header.frame_id = odom_frame;
  msg.child_frame_id = base_frame;
  msg.pose.pose = toRos(odometry.odom_from_base);
  msg.twist.twist = toRos(odometry.twist);
  for (std::size_t i = 0; i < 6; ++i) {
    msg.pose.covariance[7 * i] = kPlaneVariance;
    msg.twist.covariance[7 * i] = kPlaneVariance;
  }
  constexpr int kPlanar[] = {0, 1, 5};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      msg.pose.covariance[static_cast<std::size_t>(6 * kPlanar[row] + kPlanar[column])] =
          odometry.pose_covariance(row, column);
    }
  }
  msg.twist.covariance[0] = odometry.twist_covariance(0, 0);
  msg.twist.covariance[5] = odometry.twist_covariance(0, 1);
  msg.twist.covariance[30] = odometry.twist_covariance(1, 0);
  msg.twist.covariance[35] = odometry.twist_covariance(1, 1);
  return msg;
}

std::optional<Path2> fromRos(const nav_msgs::Path& msg) {
  Path2 path;
  path.reserve(msg.poses.size());
  for (const geometry_msgs::PoseStamped& pose : msg.poses) {
    const std::optional<Pose2> point = planar(pose.pose);
    if (!point) return std::nullopt;
    path.push_back(*point);
  }
  return path;
}

nav_msgs::Path toRos(const Path2& path, Stamp stamp, const std::string& frame) {
  nav_msgs::Path msg;
  msg.header.stamp = toRos(stamp);
  msg.header.frame_id = frame;
  msg.poses.resize(path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    msg.poses[i].header = msg.header;
    msg.poses[i].pose = toRos(path[i]);
  }
  return msg;
}

std::optional<MotionCommand> fromRos(const LocalCommand& msg) {
  if (msg.status > LocalCommand::STATUS_STOPPED || msg.holds > LocalCommand::HOLDS_VELOCITY)
    return std::nullopt;
  MotionCommand command;
  command.stamp = toStamp(msg.header.stamp);
  command.status = static_cast<MotionCommand::Status>(msg.status);
  command.reason = msg.reason;
  command.holds = static_cast<MotionCommand::Holds>(msg.holds);
  command.clear_bearing_rad = static_cast<double>(msg.clear_bearing_rad);
  command.velocity = {msg.v_mps, msg.w_radps};
  if (command.holds == MotionCommand::Holds::kVelocity && !command.velocity.isFinite()) return std::nullopt;
  if (command.holds == MotionCommand::Holds::kTarget) {
    const std::optional<Pose2> target = planar(msg.target);
    if (!target) return std::nullopt;
    command.odom_from_target = *target;
  }
  return command;
}

LocalCommand toRos(const MotionCommand& command, const std::string& odom_frame) {
  LocalCommand msg;
  msg.header.stamp = toRos(command.stamp);
  msg.header.frame_id = odom_frame;
  msg.status = static_cast<std::uint8_t>(command.status);
  msg.reason = command.reason;
  msg.holds = static_cast<std::uint8_t>(command.holds);
  msg.target = toRos(command.odom_from_target);
  msg.v_mps = command.velocity.v_mps;
  msg.w_radps = command.velocity.w_radps;
  msg.clear_bearing_rad = static_cast<float>(command.clear_bearing_rad);
  return msg;
}

std::optional<MissionStatus> fromRos(const MissionState& msg) {
  if (msg.mode > MissionState::MODE_MANUAL || msg.state > MissionState::STATE_CANCELLED) return std::nullopt;
  MissionStatus status;
  status.stamp = toStamp(msg.header.stamp);
  status.mode = static_cast<Mode>(msg.mode);
  status.phase = static_cast<MissionPhase>(msg.state);
  status.reason = msg.reason;
  status.goal_number = msg.goal_number;
  return status;
}

MissionState toRos(const MissionStatus& status) {
  MissionState msg;
  msg.header.stamp = toRos(status.stamp);
  msg.mode = static_cast<std::uint8_t>(status.mode);
  msg.state = static_cast<std::uint8_t>(status.phase);
  msg.reason = status.reason;
  msg.goal_number = status.goal_number;
  return msg;
}

}  // namespace frugal_nav
