#pragma once

#include "../../src/eval/random_paint.hpp"
#include "camera_drive_bag.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <rosbag/view.h>
#include <support/temp_folder.hpp>

#include <frugal_nav/WheelTicks.h>
#include <frugal_nav/eval/camera_layout.hpp>
#include <frugal_nav/ros/image_messages.hpp>

namespace frugal_nav::test {

constexpr std::uint64_t kCourseSeed = 500006;  // daylight, one obstacle, nobody walks
constexpr double kCourse_s = 6.0;
constexpr double kCourseSpeed_mps = 0.25;
constexpr double kCourseRate_hz = 5.0;  ///< of the images

/// A trial's room: a person to go to, and something on the straight way there.
inline eval::CameraLayout courseLayout() {
  constexpr double kRobotWidth_m = 0.25;
  const std::string source = FRUGAL_NAV_SOURCE_DIR;
  return eval::makeCameraLayout(kCourseSeed, kRobotWidth_m, eval::readTextures(source + "/worlds/textures"));
}

/// Drives straight toward the person of a layout for some seconds, from the world's origin, and writes
/// wheel_ticks, camera/image_raw (416x312, 5 Hz), camera/camera_info and the truth at the ticks' stamps.
inline void writeCourseBag(const eval::CameraLayout& layout, const std::string& path) {
  sim::SimulatorParams params;
  params.sensors = {true, false, false, true, false};
  params.camera.width_px = 416;
  params.camera.height_px = 312;
  params.camera.rate_hz = kCourseRate_hz;
  params.lighting.setting = layout.light;
  const RobotModel robot = loadRobot(std::string(FRUGAL_NAV_SOURCE_DIR) + "/urdf/frugal_bot.urdf");
  sim::Simulator simulator(layout.scene, robot, params, kCourseSeed, Pose2{});
  const sensor_msgs::CameraInfo info = infoOf(eval::pinholeOf(simulator.camera()));
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  while (toSeconds(simulator.stamp() - sim::kStartTime) < kCourse_s) {
    const sim::SimOutput output = simulator.step();
    const ros::Time time = toRos(output.stamp);
    if (output.ticks) {
      WheelTicks ticks;
      ticks.header.stamp = time;
      ticks.left = output.ticks->left;
      ticks.right = output.ticks->right;
      bag.write("wheel_ticks", time, ticks);
      bag.write("ground_truth/odom", time, odometryOf(output.stamp, simulator.groundTruth().world_from_base));
      simulator.setCommand({kCourseSpeed_mps, 0.0});
    }
    if (output.image) {
      bag.write("camera/camera_info", time, info);
      bag.write("camera/image_raw", time, imageOf({output.image->stamp, output.image->bgr, {}, {}}));
    }
  }
}

/// What such a bag holds.
struct CourseBag {
  struct Ticks {
    Stamp stamp{};
    std::int64_t left = 0;
    std::int64_t right = 0;
  };
  struct Image {
    Stamp stamp{};
    DecodedImage image;
  };
  std::vector<Ticks> ticks;
  std::vector<Image> images;
  std::vector<Odometry> truth;
  Calibration calibration;
};

inline CourseBag readCourseBag(const std::string& path) {
  rosbag::Bag bag(path);
  CourseBag course;
  for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
    if (const auto ticks = message.instantiate<WheelTicks>())
      course.ticks.push_back({toStamp(ticks->header.stamp), ticks->left, ticks->right});
    if (const auto image = message.instantiate<sensor_msgs::Image>())
      course.images.push_back({toStamp(image->header.stamp), decode(image)});
    if (const auto info = message.instantiate<sensor_msgs::CameraInfo>()) course.calibration = fromRos(*info);
    if (const auto odometry = message.instantiate<nav_msgs::Odometry>())
      course.truth.push_back(*fromRos(*odometry));
  }
  return course;
}

/// The bag of a drive, written and read back.
inline CourseBag recordCourse(const eval::CameraLayout& layout) {
  const TempFolder folder;
  writeCourseBag(layout, folder.path("course.bag"));
  return readCourseBag(folder.path("course.bag"));
}

/// Least distance between a path and the obstacles of the layout.
inline double clearance(const Path2& path, const eval::CameraLayout& layout) {
  double least_m = 10.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    constexpr int kSteps = 50;  // of 0.1 m at most, over the longest straight line
    for (int k = 0; k <= kSteps; ++k) {
      const Eigen::Vector2d way = path[i].position() - path[i - 1].position();
      const Eigen::Vector2d p = path[i - 1].position() + way * k / kSteps;
      for (const eval::Solid& obstacle : layout.obstacles) {
        if (!obstacle.overhang) least_m = std::min(least_m, obstacle.distanceTo(p));
      }
    }
  }
  return least_m;
}

/// A part of a whole; 0 of nothing.
inline double share(int part, int whole) { return whole == 0 ? 0.0 : static_cast<double>(part) / whole; }

}  // namespace frugal_nav::test
