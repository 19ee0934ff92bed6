// Plays the recorded drive through the nodes wheel_odometry and lidar_avoidance: one answer to each message.

#include "support/ros_test.hpp"

#include <algorithm>

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <std_srvs/SetBool.h>

#include <frugal_nav/LocalCommand.h>

namespace frugal_nav {
namespace {

std::size_t countOf(const std::string& topic) {
  rosbag::Bag bag(std::string(FRUGAL_NAV_SOURCE_DIR) + "/test/data/lab_drive.bag");
  return rosbag::View(bag, rosbag::TopicQuery(std::vector<std::string>{topic, "/" + topic})).size();
}

TEST(LabDriveNodes, EachTicksGivesAnOdometryAndEachScanACommand) {
  ros::NodeHandle nh;
  test::Recorder<nav_msgs::Odometry> odometry(nh, "odom");
  test::Recorder<LocalCommand> commands(nh, "avoidance/command");
  ASSERT_TRUE(odometry.waitForPublisher());
  ASSERT_TRUE(commands.waitForPublisher());
  ASSERT_TRUE(ros::service::waitForService("play/pause_playback", 20000));
  std_srvs::SetBool resume;
  resume.request.data = 0;
  ASSERT_TRUE(ros::service::call("play/pause_playback", resume));

  ASSERT_TRUE(odometry.waitForCount(countOf("wheel_ticks"), 60.0))
      << odometry.messages.size() << " odometries";
  ASSERT_TRUE(commands.waitForCount(countOf("scan"), 20.0)) << commands.messages.size() << " commands";
  EXPECT_EQ(odometry.messages.size(), countOf("wheel_ticks"));
  EXPECT_EQ(commands.messages.size(), countOf("scan"));
  const auto driving =
      std::count_if(commands.messages.begin(), commands.messages.end(), [](const LocalCommand& msg) {
        return msg.status == LocalCommand::STATUS_DRIVING && msg.holds == LocalCommand::HOLDS_VELOCITY;
      });
  EXPECT_GT(static_cast<double>(driving), 0.9 * static_cast<double>(commands.messages.size()));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "lab_drive_nodes_test");
  return RUN_ALL_TESTS();
}
