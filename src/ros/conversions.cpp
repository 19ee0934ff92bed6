#include <algorithm>
#include <cmath>

#include <frugal_nav/ros/conversions.hpp>

namespace frugal_nav {
namespace {

constexpr double kPlaneVariance =
    1e-6;  // z, roll, pitch and sideways speed: zero, as sure as a filter likes it

/// Place of the covariance of two of (x, y, yaw) among those of (x, y, z, roll, pitch, yaw).
std::size_t planarIndex(int row, int column) {
  constexpr int kPlanar[] = {0, 1, 5};
  return static_cast<std::size_t>(6 * kPlanar[row] + kPlanar[column]);
}

}  // namespace

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

geometry_msgs::PoseWithCovariance toRos(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  geometry_msgs::PoseWithCovariance msg;
  msg.pose = toRos(pose);
  for (std::size_t i = 0; i < 6; ++i) msg.covariance[7 * i] = kPlaneVariance;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      msg.covariance[planarIndex(row, column)] = covariance(row, column);
  }
  return msg;
}

Eigen::Matrix3d planarCovariance(const geometry_msgs::PoseWithCovariance& pose) {
  Eigen::Matrix3d covariance;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      covariance(row, column) = pose.covariance[planarIndex(row, column)];
  }
  return covariance;
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

std::optional<std::string> findAngleFault(const sensor_msgs::LaserScan& msg) {
  if (msg.ranges.empty()) return std::nullopt;  // which is a fault of its own
  const double swept_rad =
      static_cast<double>(msg.angle_increment) * static_cast<double>(msg.ranges.size() - 1);
  const double said_rad = static_cast<double>(msg.angle_max) - static_cast<double>(msg.angle_min);
  const double allowed_rad =
      2.0 * std::abs(static_cast<double>(msg.angle_increment)) + 0.05 * std::abs(said_rad);
  if (std::abs(swept_rad - said_rad) <= allowed_rad) return std::nullopt;
  return "angle_increment and the number of ranges do not lead from angle_min to angle_max";
}

sensor_msgs::LaserScan toRos(const LaserScan& scan, const std::string& frame) {
  sensor_msgs::LaserScan msg;
  msg.header.stamp = toRos(scan.stamp);
  msg.header.frame_id = frame;
  msg.angle_min = static_cast<float>(scan.angle_min_rad);
  msg.angle_increment = static_cast<float>(scan.angle_increment_rad);
  msg.angle_max =
      scan.ranges_m.empty() ? msg.angle_min : static_cast<float>(scan.angleOf(scan.ranges_m.size() - 1));
  msg.range_min = static_cast<float>(scan.range_min_m);
  msg.range_max = static_cast<float>(scan.range_max_m);
  msg.ranges = scan.ranges_m;
  return msg;
}

std::optional<Odometry> fromRos(const nav_msgs::Odometry& msg) {
  const std::optional<Pose2> pose = planar(msg.pose.pose);
  const Twist2 twist = planar(msg.twist.twist);
  if (!pose || !twist.isFinite()) return std::nullopt;
  Odometry odometry;
  odometry.stamp = toStamp(msg.header.stamp);
  odometry.odom_from_base = *pose;
  odometry.twist = twist;
  odometry.pose_covariance = planarCovariance(msg.pose);
  odometry.twist_covariance << msg.twist.covariance[0], msg.twist.covariance[5], msg.twist.covariance[30],
      msg.twist.covariance[35];
  return odometry;
}

nav_msgs::Odometry toRos(const Odometry& odometry, const std::string& odom_frame,
                         const std::string& base_frame) {
  nav_msgs::Odometry msg;
  msg.header.stamp = toRos(odometry.stamp);
  msg.header.frame_id = odom_frame;
  msg.child_frame_id = base_frame;
  msg.pose = toRos(odometry.odom_from_base, odometry.pose_covariance);
  msg.twist.twist = toRos(odometry.twist);
  for (std::size_t i = 0; i < 6; ++i) msg.twist.covariance[7 * i] = kPlaneVariance;
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
  command.goal_number = msg.goal_number;
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
  msg.goal_number = command.goal_number;
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

std::optional<GapSighting> fromRos(const Gap& msg) {
  GapSighting gap;
  gap.stamp = toStamp(msg.header.stamp);
  gap.found = msg.found != 0;
  gap.reason = msg.reason;
  if (!gap.found) return gap;
  gap.left_column_px = msg.left_column;
  gap.right_column_px = msg.right_column;
  gap.left_bearing_rad = msg.left_bearing_rad;
  gap.right_bearing_rad = msg.right_bearing_rad;
  gap.bearing_rad = msg.bearing_rad;
  gap.width_m = msg.width_m;
  gap.depth_m = msg.depth_m;
  gap.block = msg.block;
  gap.p_odom = {msg.node.x, msg.node.y};
  const bool finite = gap.p_odom.allFinite() && std::isfinite(gap.left_bearing_rad) &&
                      std::isfinite(gap.right_bearing_rad) && std::isfinite(gap.bearing_rad);
  return finite ? std::optional<GapSighting>(gap) : std::nullopt;
}

Gap toRos(const GapSighting& gap, const std::string& odom_frame) {
  Gap msg;
  msg.header.stamp = toRos(gap.stamp);
  msg.header.frame_id = odom_frame;
  msg.found = static_cast<std::uint8_t>(gap.found);
  msg.reason = gap.reason;
  msg.left_column = gap.left_column_px;
  msg.right_column = gap.right_column_px;
  msg.left_bearing_rad = gap.left_bearing_rad;
  msg.right_bearing_rad = gap.right_bearing_rad;
  msg.bearing_rad = gap.bearing_rad;
  msg.width_m = gap.width_m;
  msg.depth_m = gap.depth_m;
  msg.block = static_cast<std::int8_t>(gap.block);
  msg.node.x = gap.p_odom.x();
  msg.node.y = gap.p_odom.y();
  return msg;
}

std::optional<NearestObstacle> fromRos(const Obstacle& msg) {
  NearestObstacle obstacle;
  obstacle.stamp = toStamp(msg.header.stamp);
  obstacle.found = msg.found != 0;
  obstacle.reason = msg.reason;
  if (!obstacle.found) return obstacle;
  obstacle.p_odom = {msg.point.x, msg.point.y};
  obstacle.distance_m = msg.distance_m;
  obstacle.bearing_rad = msg.bearing_rad;
  obstacle.sigma_m = msg.sigma_m;
  obstacle.source = msg.source;
  obstacle.velocity_mps = {msg.velocity.x, msg.velocity.y};
  obstacle.left_px = static_cast<int>(msg.region.x_offset);
  obstacle.top_px = static_cast<int>(msg.region.y_offset);
  obstacle.width_px = static_cast<int>(msg.region.width);
  obstacle.height_px = static_cast<int>(msg.region.height);
  const bool finite = obstacle.p_odom.allFinite() && obstacle.velocity_mps.allFinite() &&
                      std::isfinite(obstacle.distance_m) && std::isfinite(obstacle.bearing_rad);
  return finite ? std::optional<NearestObstacle>(obstacle) : std::nullopt;
}

Obstacle toRos(const NearestObstacle& obstacle, const std::string& odom_frame) {
  Obstacle msg;
  msg.header.stamp = toRos(obstacle.stamp);
  msg.header.frame_id = odom_frame;
  msg.found = static_cast<std::uint8_t>(obstacle.found);
  msg.reason = obstacle.reason;
  msg.point.x = obstacle.p_odom.x();
  msg.point.y = obstacle.p_odom.y();
  msg.distance_m = obstacle.distance_m;
  msg.bearing_rad = obstacle.bearing_rad;
  msg.sigma_m = obstacle.sigma_m;
  msg.source = obstacle.source;
  msg.velocity.x = obstacle.velocity_mps.x();
  msg.velocity.y = obstacle.velocity_mps.y();
  msg.region.x_offset = static_cast<std::uint32_t>(std::max(obstacle.left_px, 0));
  msg.region.y_offset = static_cast<std::uint32_t>(std::max(obstacle.top_px, 0));
  msg.region.width = static_cast<std::uint32_t>(std::max(obstacle.width_px, 0));
  msg.region.height = static_cast<std::uint32_t>(std::max(obstacle.height_px, 0));
  return msg;
}

}  // namespace frugal_nav
