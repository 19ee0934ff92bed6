#include <cmath>

#include <ros/console.h>

#include <frugal_nav/ros/conversions.hpp>
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
    const geometry_msgs::Transform transform =
        buffer_.lookupTransform(base_frame_, sensor_frame, ros::Time(0)).transform;
    if (!yawOf(transform.rotation)) {
      ROS_ERROR_THROTTLE(5.0, "the transform from %s to %s has no sound quaternion", base_frame_.c_str(),
                         sensor_frame.c_str());
      return std::nullopt;
    }
    const Eigen::Isometry3d pose = fromRos(transform);
    known_[sensor_frame] = pose;
    listener_.reset();
    return pose;
  } catch (const tf2::TransformException& error) {
    ROS_WARN_THROTTLE(5.0, "no transform from %s to %s: %s", base_frame_.c_str(), sensor_frame.c_str(),
                      error.what());
    return std::nullopt;
  }
}

std::variant<Pose2, std::string> SensorPoses::laser(const std::string& laser_frame) {
  constexpr double kLevel = 0.99;  // cosine between the two z axes: eight degrees
  const std::optional<Eigen::Isometry3d> pose = baseFrom(laser_frame);
  if (!pose) return "no transform from " + base_frame_ + " to " + laser_frame;
  if (!((*pose)(2, 2) > kLevel)) {
    return "the laser \"" + laser_frame + "\" is not mounted level with z up in \"" + base_frame_ + "\"";
  }
  return toPose2(*pose);
}

}  // namespace frugal_nav
