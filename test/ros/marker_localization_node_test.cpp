#include "marker_localization_graph.hpp"

#include <geometry_msgs/TwistStamped.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <frugal_nav/SetPose.h>
#include <frugal_nav/ros/marker_messages.hpp>

namespace frugal_nav {
namespace {

using test::kMapFromOdom;
using test::PoseMessage;
using testing::AllOf;
using testing::HasSubstr;

class MarkerLocalizationNodeTest : public test::MarkerLocalizationGraph {};

TEST_F(MarkerLocalizationNodeTest, TellsNothingBeforeTheFirstFixButThatItHasNone) {
  start();
  drive(25);
  EXPECT_TRUE(poses_.messages.empty());
  EXPECT_TRUE(tf_.messages.empty());
  const MarkerObservationArray* nothing =
      show(graph_.imageOf(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(90))));
  ASSERT_NE(nothing, nullptr);
  EXPECT_TRUE(nothing->markers.empty());
  EXPECT_EQ(nothing->image_width, 320U);
  EXPECT_FALSE(nothing->accepted);
  EXPECT_EQ(nothing->reason, toText(MarkerFix::Status::kNoMarker));
  ASSERT_TRUE(test::waitUntil([this] {
    graph_.clock.advance(0.1);
    return status().find("no fix yet") != std::string::npos;
  }));
}

TEST_F(MarkerLocalizationNodeTest, GivesPoseAndTransformOfEachOdometryOnce) {
  start();
  localize();
  graph_.pose = {0.0, 0.0, 0.0};
  drive(20);
  ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
  ASSERT_TRUE(waitForTransform());
  ASSERT_GE(poses_.messages.size(), 20U);
  expectAtTruth(poses_.messages.back().pose.pose);
  EXPECT_EQ(poses_.messages.back().header.frame_id, "map");
  EXPECT_GT(poses_.messages.back().pose.covariance[0], 0.0);
  ros::Time last;
  for (const tf2_msgs::TFMessage& message : tf_.messages) {
    const geometry_msgs::TransformStamped& transform = message.transforms.at(0);
    EXPECT_EQ(transform.header.frame_id, "map");
    EXPECT_EQ(transform.child_frame_id, "odom");
    EXPECT_GT(transform.header.stamp, last);
    EXPECT_NE(poseAt(transform.header.stamp), nullptr);
    last = transform.header.stamp;
  }
  const auto& transform = tf_.messages.back().transforms.at(0).transform;
  EXPECT_NEAR(transform.translation.x, kMapFromOdom.x_m, 0.05);
  EXPECT_NEAR(transform.translation.y, kMapFromOdom.y_m, 0.05);
  graph_.publishOdometry();  // the same stamp again
  const std::size_t count = tf_.messages.size();
  EXPECT_FALSE(test::waitUntil([&] { return tf_.messages.size() > count; }, 0.2));
}

TEST_F(MarkerLocalizationNodeTest, DescribesEachMarker) {
  start();
  MarkerMap map = test::wallMap();
  map.markers[17] = map.markers.at(1);  // one that nobody told the node of
  map.markers.erase(1);
  map.markers[17].id = 17;
  tick();
  const MarkerObservationArray* seen = show(picture(map));
  ASSERT_NE(seen, nullptr);
  EXPECT_TRUE(seen->accepted) << seen->reason;
  EXPECT_THAT(seen->unlisted_ids, testing::ElementsAre(17));
  ASSERT_GE(seen->markers.size(), 2U);
  const MarkerObservation& marker = seen->markers[0];
  EXPECT_EQ(marker.id, 0);
  EXPECT_DOUBLE_EQ(marker.size_m, 0.20);
  EXPECT_TRUE(marker.accepted);
  EXPECT_EQ(marker.reason, "used");
  EXPECT_TRUE(marker.has_pose);
  EXPECT_NEAR(marker.pose.pose.position.z, 2.4, 0.2);
  EXPECT_LT(marker.image_error_px, 1.0);
  EXPECT_LT(marker.object_error_m, 0.01);
  EXPECT_GT(marker.pose.covariance[14], marker.pose.covariance[0]) << "depth is what a camera knows least";
  EXPECT_GT(marker.corners_px[2], marker.corners_px[0]) << "upper right of upper left";
}

TEST_F(MarkerLocalizationNodeTest, TheTransformEndsWhenTheRobotIsLost) {
  pnh_.setParam("max_sigma_m", 0.2);
  start();
  localize();
  graph_.clock.advance(5.0);
  graph_.publishOdometry();  // nobody knows where the robot went in the meantime
  ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
  const std::size_t transforms = tf_.messages.size();
  tick();
  EXPECT_FALSE(test::waitUntil([&] { return tf_.messages.size() > transforms; }, 0.2));
  ASSERT_NE(show(picture()), nullptr);
  tick();
  EXPECT_TRUE(waitForTransform());
}

TEST_F(MarkerLocalizationNodeTest, LeavesTheTransformToAnother) {
  pnh_.setParam("publish_tf", false);
  start();
  tick();
  ASSERT_NE(show(picture()), nullptr);
  drive(5);
  ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
  EXPECT_TRUE(tf_.messages.empty());
}

TEST_F(MarkerLocalizationNodeTest, TakesAPoseByTopicAndByService) {
  start();
  ros::Publisher set_pub = graph_.nh.advertise<PoseMessage>("set_pose", 1);
  ASSERT_TRUE(test::waitForSubscriber(set_pub));
  drive(5);
  PoseMessage given;
  given.header.frame_id = "map";
  given.pose.pose = toRos(Pose2{5.0, 6.0, 0.5});
  set_pub.publish(given);
  ASSERT_TRUE(test::waitUntil([this] {
    tick();
    return !poses_.messages.empty();
  }));
  EXPECT_NEAR(poses_.messages.back().pose.pose.position.x, 5.0, 1e-6);
  EXPECT_NEAR(poses_.messages.back().pose.covariance[0], 0.04, 0.01) << "set_pose_sigma_m 0.2";
  ros::Publisher initial_pub = graph_.nh.advertise<PoseMessage>("initialpose", 1);  // rviz' button
  ASSERT_TRUE(test::waitForSubscriber(initial_pub));
  given.pose.pose = toRos(Pose2{3.0, 6.0, 0.5});
  initial_pub.publish(given);
  ASSERT_TRUE(test::waitUntil([this] {
    tick();
    return poses_.messages.back().pose.pose.position.x < 4.0;
  }));
  SetPose service;
  service.request.pose = given;
  service.request.pose.pose.pose.position.x = 7.0;
  service.request.pose.pose.covariance[0] = service.request.pose.pose.covariance[7] = 0.01;
  service.request.pose.pose.covariance[35] = 0.01;
  const std::string name = graph_.nh.resolveName("set_pose");
  ASSERT_TRUE(callInBackground([&] { return ros::service::call(name, service); }));
  EXPECT_TRUE(service.response.success) << service.response.message;
  tick();
  ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
  EXPECT_NEAR(poseAt(graph_.clock.now())->pose.pose.position.x, 7.0, 1e-3);
  service.request.pose.header.frame_id = "odom";
  ASSERT_TRUE(callInBackground([&] { return ros::service::call(name, service); }));
  EXPECT_FALSE(service.response.success);
  EXPECT_THAT(service.response.message, AllOf(HasSubstr("odom"), HasSubstr("map")));
}

TEST_F(MarkerLocalizationNodeTest, InputsCanBeSwitchedOff) {
  start();
  ASSERT_TRUE(call("use_markers", false));
  tick();
  const MarkerObservationArray* seen = show(picture());
  ASSERT_NE(seen, nullptr);
  EXPECT_FALSE(seen->accepted);
  EXPECT_FALSE(seen->markers.empty());
  EXPECT_EQ(seen->reason, toText(FilterStatus::kDisabled));
  EXPECT_TRUE(poses_.messages.empty());
  ASSERT_TRUE(call("use_markers", true));
  localize();
  ASSERT_TRUE(call("use_imu", false));
  ASSERT_TRUE(test::waitUntil([this] {
    tick();
    return status().find("gyro silent") != std::string::npos;
  }));
  ASSERT_TRUE(call("use_imu", true));
  ASSERT_TRUE(call("use_odometry", false));
  ASSERT_TRUE(test::waitUntil([this] {
    tick();
    return status().find("twist silent") != std::string::npos;
  }));
}

TEST_F(MarkerLocalizationNodeTest, GoesOnWithTheImagesWhileOdometryIsSilent) {
  start();
  localize();
  const std::size_t transforms = tf_.messages.size();
  graph_.clock.advance(5.0);
  const MarkerObservationArray* seen = show(picture());
  ASSERT_NE(seen, nullptr);
  EXPECT_TRUE(seen->accepted) << seen->reason;
  ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
  expectAtTruth(poseAt(graph_.clock.now())->pose.pose);
  EXPECT_EQ(tf_.messages.size(), transforms);
  tick();  // odometry is back
  EXPECT_TRUE(test::waitUntil([&] { return tf_.messages.size() > transforms; }));
}

TEST_F(MarkerLocalizationNodeTest, DrivesByCommandedSpeed) {
  pnh_.setParam("filter/twist_source", "command");
  start();
  ros::Publisher command_pub = graph_.nh.advertise<geometry_msgs::TwistStamped>("cmd_vel_stamped", 10);
  ASSERT_TRUE(test::waitForSubscriber(command_pub));
  localize();
  for (int i = 0; i < 20; ++i) {
    graph_.clock.advance(0.05);
    geometry_msgs::TwistStamped command;
    command.header.stamp = graph_.clock.now();
    command.twist.linear.x = 0.2;
    command_pub.publish(command);
    graph_.pose = graph_.pose * arcMotion({i == 0 ? 0.0 : 0.2, 0.0}, 0.05);
  }
  ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
  expectAtTruth(poseAt(graph_.clock.now())->pose.pose);
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "marker_localization_node_test");
  ros::NodeHandle nh;  // keeps ROS running between the tests
  return RUN_ALL_TESTS();
}
