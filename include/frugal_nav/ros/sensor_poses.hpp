#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include <Eigen/Geometry>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <frugal_nav/common/geometry.hpp>

namespace frugal_nav {

/// Where sensors are mounted, from tf. A pose is asked for until it is known and then kept: listening to tf
/// for ever would cost a thread and every joint's message.
class SensorPoses {
 public:
  explicit SensorPoses(std::string base_frame);

  /// base_from_sensor; nothing, and a warning now and then, while tf does not know it.
  std::optional<Eigen::Isometry3d> baseFrom(const std::string& sensor_frame);
  /// base_from_laser on the floor plane, of a laser that is mounted level with z up; or why its scans cannot
  /// be used.
  std::variant<Pose2, std::string> laser(const std::string& laser_frame);

 private:
  std::string base_frame_;
  std::map<std::string, Eigen::Isometry3d> known_;
  tf2_ros::Buffer buffer_;
  std::unique_ptr<tf2_ros::TransformListener> listener_;  // while a pose is unknown
};

}  // namespace frugal_nav
