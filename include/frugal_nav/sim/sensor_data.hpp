#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/time.hpp>

namespace frugal_nav::sim {

/// One reading of the cumulative encoder counts.
struct WheelTicks {
  Stamp stamp{};
  std::int64_t left = 0;
  std::int64_t right = 0;
};

/// One reading of the IMU, in imu_link. At rest a level IMU reads +9.81 along z (REP-145).
struct ImuSample {
  Stamp stamp{};
  Eigen::Vector3d angular_velocity_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();
};

/// One image of a camera: CV_8UC3, BGR.
struct CameraImage {
  Stamp stamp{};
  cv::Mat bgr;
};

/// One depth image registered to its camera: CV_32FC1, metres along the optical axis, NaN where unknown
/// (REP-118).
struct DepthImage {
  Stamp stamp{};
  cv::Mat depth_m;
};

/// A touch between the robot and something else.
struct Contact {
  Stamp stamp{};
  std::string robot_link;
  std::string other;                                  ///< model or person
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< [m]
  double depth_m = 0.0;                               ///< how far the shapes overlapped
  double speed_mps = 0.0;                             ///< of the robot when it began
  bool driven_into = true;  ///< the robot moved toward it; false: it came to the robot
};

/// The truth about the robot.
struct GroundTruth {
  Stamp stamp{};
  Pose2 world_from_base;
  Twist2 twist;  ///< in base_link
};

}  // namespace frugal_nav::sim
