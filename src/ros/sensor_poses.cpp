#include <ros/console.h>

#include <frugal_nav/ros/sensor_poses.hpp>

namespace frugal_nav {
namespace {

Eigen::Isometry3d fromRos(const geometry_msgs::Transform& transform) {
  const geometry_msgs::Vector3& t = transform.translation;
  const geometry_msgs::Quaternion& q = transform.rotation;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << t.x, t.y, t.z;
  pose.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  return pose;
}

}  // namespace

SensorPoses::SensorPoses(std::string base_frame)
    : base_frame_(std::move(base_frame)), listener_(std::make_unique<tf2_ros::TransformListener>(buffer_)) {}

std::optional<Eigen::Isometry3d> SensorPoses::baseFrom(const std::string& sensor_frame) {
  const auto known = known_.find(sensor_frame);
  if (known != known_.end()) return known->second;
  if (!listener_) listener_ = std::make_unique<tf2_ros::TransformListener>(buffer_);
  try {
    const Eigen::Isometry3d pose =
        fromRos(buffer_.lookupTransform(base_frame_, sensor_frame, ros::Time(0)).transform);
    known_[sensor_frame] = pose;
    listener_.reset();
    return pose;
  } catch (const tf2::TransformException& error) {
    ROS_WARN_THROTTLE(5.0, "no transform from %s to %s: %s", base_frame_.c_str(), sensor_frame.c_str(),
                      error.what());
    return std::nullopt;
  }
}

}  // namespace frugal_nav
