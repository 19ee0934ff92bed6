#include <algorithm>
#include <cmath>
#include <limits>

#include <sensor_msgs/point_cloud2_iterator.h>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/visual_messages.hpp>

namespace frugal_nav {
namespace {

constexpr std::uint8_t kFloat = sensor_msgs::PointField::FLOAT32;

std_msgs::Header headerOf(Stamp stamp, const std::string& frame) {
  std_msgs::Header header;
  header.stamp = toRos(stamp);
  header.frame_id = frame;
  return header;
}

template <class Matrix>
void copyCovariance(const Matrix& from, boost::array<double, 36>& to) {
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column)
      to[static_cast<std::size_t>(6 * row + column)] = from(row, column);
  }
}

/// Velocity in the body's frame between two poses, with the variance by which the pose's has grown.
void fillTwist(const VisualOdometryOutput& output, const VisualOdometryOutput* before,
               geometry_msgs::TwistWithCovariance& twist) {
  constexpr double kLeastVariance = 1e-6;  // a filter divides by it
  constexpr double kUnknownVariance = 1e3;
  const double span_s = before != nullptr ? toSeconds(output.stamp - before->stamp) : 0.0;
  Matrix6d covariance = kUnknownVariance * Matrix6d::Identity();
  if (span_s > 0.0) {
    const Eigen::Isometry3d moved = before->odom_from_base.inverse() * output.odom_from_base;
    const Eigen::AngleAxisd turn(moved.linear());
    const Eigen::Vector3d v = moved.translation() / span_s;
    const Eigen::Vector3d w = turn.axis() * (turn.angle() / span_s);
    twist.twist.linear.x = v.x();
    twist.twist.linear.y = v.y();
    twist.twist.linear.z = v.z();
    twist.twist.angular.x = w.x();
    twist.twist.angular.y = w.y();
    twist.twist.angular.z = w.z();
    const Eigen::Matrix<double, 6, 1> grown = (output.covariance - before->covariance).diagonal();
    covariance = (grown.cwiseAbs() / (span_s * span_s)).cwiseMax(kLeastVariance).asDiagonal();
  }
  copyCovariance(covariance, twist.covariance);
}

}  // namespace

geometry_msgs::Pose toRos(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  geometry_msgs::Pose msg;
  msg.position.x = pose.translation().x();
  msg.position.y = pose.translation().y();
  msg.position.z = pose.translation().z();
  msg.orientation.x = q.x();
  msg.orientation.y = q.y();
  msg.orientation.z = q.z();
  msg.orientation.w = q.w();
  return msg;
}

VoStatus toRos(const VisualStatus& status, Stamp stamp, const std::string& frame) {
  VoStatus msg;
  msg.header = headerOf(stamp, frame);
  msg.state = static_cast<std::uint8_t>(status.state);
  if (status.reason != VisualReason::kNone) msg.reason = text(status.reason);
  msg.features = status.features;
  msg.inliers = status.inliers;
  msg.scale = status.scale;
  msg.scale_sigma = status.scale_sigma;
  return msg;
}

nav_msgs::Odometry toRos(const VisualOdometryOutput& output, const VisualOdometryOutput* before,
                         const std::string& odom_frame, const std::string& base_frame) {
  nav_msgs::Odometry msg;
  msg.header = headerOf(output.stamp, odom_frame);
  msg.child_frame_id = base_frame;
  msg.pose.pose = toRos(output.odom_from_base);
  copyCovariance(output.covariance, msg.pose.covariance);
  fillTwist(output, before, msg.twist);
  return msg;
}

sensor_msgs::PointCloud2 pointsMessage(const VisualOdometryOutput& output,
                                       const Eigen::Isometry3d& odom_from_camera,
                                       const std::string& odom_frame) {
  sensor_msgs::PointCloud2 msg;
  msg.header = headerOf(output.stamp, odom_frame);
  sensor_msgs::PointCloud2Modifier modifier(msg);
  modifier.setPointCloud2Fields(6, "x", 1, kFloat, "y", 1, kFloat, "z", 1, kFloat, "u", 1, kFloat, "v", 1,
                                kFloat, "sigma", 1, kFloat);
  msg.is_dense = true;
  if (!output.is_metric) return msg;
  modifier.resize(output.points.size());
  sensor_msgs::PointCloud2Iterator<float> at(msg, "x");
  for (const VisualPoint& point : output.points) {
    const Eigen::Vector3f p = (odom_from_camera * point.p_camera).cast<float>();
    at[0] = p.x();
    at[1] = p.y();
    at[2] = p.z();
    at[3] = static_cast<float>(point.pixel.x());
    at[4] = static_cast<float>(point.pixel.y());
    at[5] = static_cast<float>(point.sigma_m);
    ++at;
  }
  return msg;
}

sensor_msgs::PointCloud2 cloudMessage(const std::vector<Eigen::Vector3f>& points, Stamp stamp,
                                      const std::string& frame) {
  sensor_msgs::PointCloud2 msg;
  msg.header = headerOf(stamp, frame);
  sensor_msgs::PointCloud2Modifier modifier(msg);
  modifier.setPointCloud2Fields(3, "x", 1, kFloat, "y", 1, kFloat, "z", 1, kFloat);
  modifier.resize(points.size());
  msg.is_dense = true;
  sensor_msgs::PointCloud2Iterator<float> at(msg, "x");
  for (const Eigen::Vector3f& p : points) {
    at[0] = p.x();
    at[1] = p.y();
    at[2] = p.z();
    ++at;
  }
  return msg;
}

Obstacle toRos(const VisualObstacleResult& result, const Eigen::Isometry3d& odom_from_visual,
               const cv::Rect& region, Stamp stamp, const std::string& odom_frame) {
  Obstacle msg;
  msg.header = headerOf(stamp, odom_frame);
  msg.found = result.obstacle.has_value();
  msg.reason = result.reason;
  msg.source = "vo";
  msg.distance_m = msg.sigma_m = std::numeric_limits<double>::quiet_NaN();
  msg.region.x_offset = static_cast<std::uint32_t>(std::max(0, region.x));
  msg.region.y_offset = static_cast<std::uint32_t>(std::max(0, region.y));
  msg.region.width = static_cast<std::uint32_t>(std::max(0, region.width));
  msg.region.height = static_cast<std::uint32_t>(std::max(0, region.height));
  if (!result.obstacle) return msg;
  const VisualObstacle& obstacle = *result.obstacle;
  const Eigen::Vector3d p_odom = odom_from_visual * obstacle.p_odom;
  msg.point.x = p_odom.x();
  msg.point.y = p_odom.y();
  msg.distance_m = obstacle.distance_m;
  msg.bearing_rad = obstacle.bearing_rad;
  msg.sigma_m = obstacle.sigma_m;
  return msg;
}

}  // namespace frugal_nav
