#pragma once

#include "camera_drive_bag.hpp"

#include <string>

#include <sensor_msgs/Imu.h>

#include <frugal_nav/odometry/wheel_odometry.hpp>
#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/ros/wheel_odometry_params.hpp>
#include <frugal_nav/sim/simulator.hpp>

namespace frugal_nav::test {

constexpr double kStandUntil_s = 3.0;
constexpr double kDriveUntil_s = 14.0;

/// Stands, drives 1.8 m along the wall, turns left, drives on.
inline Twist2 markerDriveCommand(double since_start_s) {
  if (since_start_s < kStandUntil_s) return {};
  if (since_start_s < 9.0) return {0.3, 0.0};
  if (since_start_s < 11.0) return {0.0, 0.6};
  return since_start_s < kDriveUntil_s ? Twist2{0.3, -0.2} : Twist2{};
}

inline WheelOdometry simulatedWheels(const RobotModel& robot) {
  const std::string config = std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/";
  auto params = loadParamFile<WheelOdometryNodeParams>(config + "wheel_odometry.yaml");
  const std::string calibration = config + "simulated/wheel_odometry.yaml";
  assign(readParamFile(calibration), calibration, params);
  return WheelOdometry(params.odometry, {robot.drive.radius_m, robot.drive.separation_m});
}

/// Drives through the shipped hall of markers and writes what its robot's sensors gave into a bag: odom at 50
/// Hz, imu/data_raw at 100 Hz, camera/image_raw and camera/camera_info at 5 Hz, and the truth at odom's
/// stamps. The number of contacts.
inline int writeMarkerDriveBag(const std::string& path) {
  const std::string source = FRUGAL_NAV_SOURCE_DIR;
  const RobotModel robot = loadRobot(source + "/urdf/frugal_bot.urdf");
  sim::SimulatorParams params;
  params.sensors = {true, true, false, true, false};
  params.camera.rate_hz = 5.0;
  constexpr std::uint64_t kSeed = 500006;
  sim::Simulator simulator(sim::loadWorld(source + "/worlds/marker_hall.world", sim::ResourcePath()).scene,
                           robot, params, kSeed, {-4.0, -2.6, 0.1});
  const sensor_msgs::CameraInfo info = infoOf(eval::pinholeOf(simulator.camera()));
  WheelOdometry wheels = simulatedWheels(robot);
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  while (simulator.stamp() < sim::kStartTime + fromSeconds(kDriveUntil_s + 1.0)) {
    simulator.setCommand(markerDriveCommand(toSeconds(simulator.stamp() - sim::kStartTime)));
    const sim::SimOutput output = simulator.step();
    const ros::Time now = toRos(output.stamp);
    if (output.imu) {
      sensor_msgs::Imu imu;
      imu.header.stamp = toRos(output.imu->stamp);
      imu.header.frame_id = "imu_link";
      imu.angular_velocity.z = output.imu->angular_velocity_radps.z();
      bag.write("imu/data_raw", now, imu);
    }
    if (output.ticks) {
      const sim::WheelTicks& ticks = *output.ticks;
      if (const auto odometry = wheels.addTicks(ticks.stamp, ticks.left, ticks.right))
        bag.write("odom", now, toRos(*odometry, "odom", "base_link"));
      bag.write("ground_truth/odom", now, odometryOf(output.stamp, simulator.groundTruth().world_from_base));
    }
    if (output.image) {
      sensor_msgs::CameraInfo of_image = info;
      of_image.header.stamp = toRos(output.image->stamp);
      bag.write("camera/camera_info", now, of_image);
      bag.write("camera/image_raw", now, imageOf({output.image->stamp, output.image->bgr, {}, {}}));
    }
  }
  return simulator.contactCount();
}

}  // namespace frugal_nav::test
