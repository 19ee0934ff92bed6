#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/odometry/visual_odometry.hpp>
#include <frugal_nav/odometry/wheel_odometry.hpp>
#include <frugal_nav/robot/robot_model.hpp>
#include <frugal_nav/sim/simulator.hpp>

namespace frugal_nav::eval {

/// A simulated camera's calibration.
Pinhole pinholeOf(const sim::Camera& camera);

/// One piece of a drive: straight ahead, then a turn on the spot.
struct DriveLeg {
  double length_m = 0.0;
  double turn_rad = 0.0;
};

/// How the legs are driven.
struct DriveSpeed {
  double v_mps = 0.3;
  double w_radps = 0.6;
};

/// One image of a recorded drive.
struct DriveImage {
  Stamp stamp{};
  cv::Mat bgr;
  Pose2 world_from_base;  ///< the truth at the stamp
  Pose2 odom_from_base;   ///< the wheels at the stamp; odom starts at the true pose
};

/// What the camera saw on a drive.
struct DriveRecording {
  Pinhole camera;
  Eigen::Isometry3d base_from_camera = Eigen::Isometry3d::Identity();
  std::vector<DriveImage> images;
  double length_m = 0.0;  ///< true length of the way
  int contacts = 0;
};

/// Drives legs in a scene by wheel odometry and records the camera; `wheels` without its starting pose and
/// ticks, which are the simulation's. Throws ConfigError as the Simulator.
DriveRecording recordDrive(const sim::Scene& scene, const RobotModel& robot, sim::SimulatorParams params,
                           std::uint64_t seed, const Pose2& world_from_start,
                           const std::vector<DriveLeg>& legs, const DriveSpeed& speed = {},
                           WheelOdometryParams wheels = {});

/// Visual odometry over a recording.
struct VisualDriveResult {
  std::vector<Pose2> visual;  ///< one pose an image, in the world
  std::vector<VisualOdometryOutput> outputs;
  std::vector<Eigen::Vector3f> cloud;  ///< the accumulated map, in the world
  double tracked_share = 0.0;          ///< images with state tracking
  double mean_ms = 0.0;                ///< processor time an image, all threads
  double final_error_m = 0.0;
  double final_wheel_error_m = 0.0;
};

/// Runs visual odometry over the recorded images and wheels.
VisualDriveResult runVisualOdometry(const DriveRecording& recording, const VisualOdometryParams& params);

}  // namespace frugal_nav::eval
