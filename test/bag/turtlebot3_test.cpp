// Wheel odometry from the joint states of a real robot, where the bag is at hand (the tutorial bag of the
// package fuse, in data/bags of the folder that FRUGAL_NAV_SHARED names).

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/JointState.h>

#include <frugal_nav/common/odometry_buffer.hpp>
#include <frugal_nav/odometry/wheel_odometry.hpp>
#include <frugal_nav/ros/conversions.hpp>

namespace frugal_nav {
namespace {

TEST(Turtlebot3, WheelOdometryFollowsTheRobotsOwn) {
  const char* shared = std::getenv("FRUGAL_NAV_SHARED");
  const std::string folder =
      shared != nullptr ? std::string(shared) : std::string(FRUGAL_NAV_SOURCE_DIR) + "/../shared";
  const std::string path = folder + "/data/bags/turtlebot3.bag";
  if (!std::ifstream(path))
    GTEST_SKIP() << "no " << path << ": set FRUGAL_NAV_SHARED to the folder of shared data";

  // Geometry of the TurtleBot3 Waffle, from its manual; angles come 30 times a second.
  WheelOdometry wheels(WheelOdometryParams{}, {0.033, 0.287});
  OdometryBuffer own(fromSeconds(300.0));
  std::vector<Odometry> ours;
  rosbag::Bag bag(path);
  for (const rosbag::MessageInstance& instance : rosbag::View(bag)) {
    if (const auto msg = instance.instantiate<nav_msgs::Odometry>()) own.add(*fromRos(*msg));
    const auto joints = instance.instantiate<sensor_msgs::JointState>();
    if (!joints || joints->position.size() < 2) continue;
    const auto right = std::find_if(joints->name.begin(), joints->name.end(), [](const std::string& name) {
      return name.find("right") != std::string::npos;
    });
    const std::size_t right_index = static_cast<std::size_t>(right - joints->name.begin());
    ASSERT_LT(right_index, 2U);
    const auto odometry = wheels.addAngles(toStamp(joints->header.stamp), joints->position[1 - right_index],
                                           joints->position[right_index]);
    if (odometry) ours.push_back(*odometry);
  }
  ASSERT_GT(ours.size(), 2000U);

  // The robot's own odometry takes its heading from the IMU, and the way turns by 30 rad in all: the headings
  // part. So what is compared is the motion of each second.
  constexpr std::size_t kSecond = 30;
  double ours_m = 0.0;
  double theirs_m = 0.0;
  double squares_m2 = 0.0;
  int seconds = 0;
  for (std::size_t i = kSecond; i < ours.size(); i += kSecond) {
    const auto from = own.at(ours[i - kSecond].stamp);
    const auto to = own.at(ours[i].stamp);
    if (!from || !to) continue;
    const Pose2 our_motion = ours[i - kSecond].odom_from_base.inverse() * ours[i].odom_from_base;
    const Pose2 their_motion = from->odom_from_base.inverse() * to->odom_from_base;
    ours_m += our_motion.position().norm();
    theirs_m += their_motion.position().norm();
    squares_m2 += (our_motion.position() - their_motion.position()).squaredNorm();
    ++seconds;
  }
  ASSERT_GT(seconds, 80);
  EXPECT_GT(ours_m, 20.0);
  EXPECT_NEAR(ours_m, theirs_m, 0.02 * theirs_m);
  // In a second it drives 0.28 m; a heading that is off by a tenth of a turn's 0.6 rad displaces that by 8
  // mm, and stamps that differ by one of its periods by 9 mm.
  EXPECT_LT(std::sqrt(squares_m2 / seconds), 0.02);
  RecordProperty("rms_mm_per_second", static_cast<int>(1000.0 * std::sqrt(squares_m2 / seconds)));
  RecordProperty("ours_mm", static_cast<int>(1000.0 * ours_m));
  RecordProperty("theirs_mm", static_cast<int>(1000.0 * theirs_m));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
