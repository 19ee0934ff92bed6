#pragma once

#include <string>

#include <nav_msgs/Odometry.h>
#include <opencv2/core.hpp>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <frugal_nav/eval/visual_drive.hpp>
#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/sim/sdf_world.hpp>

namespace frugal_nav::test {

/// Where the person of the drive stands.
constexpr Pose2 kPerson{-3.0, 2.3, -M_PI_2};

inline sensor_msgs::CameraInfo infoOf(const Pinhole& camera) {
  sensor_msgs::CameraInfo msg;
  msg.header.frame_id = "camera_optical_frame";
  msg.width = static_cast<std::uint32_t>(camera.width_px);
  msg.height = static_cast<std::uint32_t>(camera.height_px);
  msg.distortion_model = "plumb_bob";
  msg.D = {camera.k1, camera.k2, camera.p1, camera.p2, camera.k3};
  msg.K = {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
  return msg;
}

inline sensor_msgs::Image imageOf(const eval::DriveImage& image) {
  sensor_msgs::Image msg;
  msg.header.stamp = toRos(image.stamp);
  msg.header.frame_id = "camera_optical_frame";
  msg.width = static_cast<std::uint32_t>(image.bgr.cols);
  msg.height = static_cast<std::uint32_t>(image.bgr.rows);
  msg.encoding = "bgr8";
  msg.step = 3 * msg.width;
  msg.data.assign(image.bgr.data, image.bgr.data + image.bgr.total() * image.bgr.elemSize());
  return msg;
}

inline nav_msgs::Odometry odometryOf(Stamp stamp, const Pose2& odom_from_base) {
  Odometry odometry;
  odometry.stamp = stamp;
  odometry.odom_from_base = odom_from_base;
  return toRos(odometry, "odom", "base_link");
}

/// Drives two metres through the shipped lab toward a standing person, in daylight, and writes what the
/// camera saw and the wheels told into a bag: camera/image_raw, camera/camera_info, odom at the images'
/// stamps, and the truth. odom is the world's frame.
inline void writeCameraDriveBag(const std::string& path) {
  const std::string source = FRUGAL_NAV_SOURCE_DIR;
  sim::Scene scene = sim::loadWorld(source + "/worlds/lab.world", sim::ResourcePath()).scene;
  sim::Person person;
  person.name = "goal";
  person.appearance = 500003;
  person.waypoints.push_back({0.0, kPerson});
  scene.people.push_back(person);
  sim::SimulatorParams params;
  params.lighting.setting = "daylight";
  constexpr std::uint64_t kSeed = 500001;
  const eval::DriveRecording drive = eval::recordDrive(scene, loadRobot(source + "/urdf/frugal_bot.urdf"),
                                                       params, kSeed, {-3.7, -2.4, M_PI_2}, {{2.0, 0.0}});
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  for (const eval::DriveImage& image : drive.images) {
    const ros::Time time = toRos(image.stamp);
    sensor_msgs::CameraInfo info = infoOf(drive.camera);
    info.header.stamp = time;
    bag.write("camera/camera_info", time, info);
    bag.write("camera/image_raw", time, imageOf(image));
    bag.write("odom", time, odometryOf(image.stamp, image.odom_from_base));
    bag.write("ground_truth/odom", time, odometryOf(image.stamp, image.world_from_base));
  }
}

}  // namespace frugal_nav::test
