// Wheel odometry from the joint states of a real robot, where the bag is at hand (the tutorial bag of the
// package fuse, in data/bags of the folder that FRUGAL_NAV_SHARED names).

#include <algorithm>
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

  // Geometry of the TurtleBot3 Burger, from its manual; angles come 30 times a second.
  WheelOdometry wheels(WheelOdometryParams{}, {0.033, 0.160});
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

  double length_m = 0.0;
  double worst_m = 0.0;
  std::optional<Pose2> own_from_ours;
  Pose2 last;
  for (const Odometry& odometry : ours) {
    const auto theirs = own.at(odometry.stamp);
    if (!theirs) continue;
    if (!own_from_ours) own_from_ours = theirs->odom_from_base * odometry.odom_from_base.inverse();
    length_m += distance(last, odometry.odom_from_base);
    last = odometry.odom_from_base;
    worst_m = std::max(worst_m, distance(theirs->odom_from_base, *own_from_ours * odometry.odom_from_base));
  }
  EXPECT_GT(length_m, 1.0);
  // The robot's own odometry takes its heading from the IMU: ours may differ by the slip in its turns.
  EXPECT_LT(worst_m, 0.05 * length_m);
  RecordProperty("length_mm", static_cast<int>(1000.0 * length_m));
  RecordProperty("worst_mm", static_cast<int>(1000.0 * worst_m));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
