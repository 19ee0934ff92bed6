#include "camera_graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/point_cloud2_iterator.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>
#include <unit/visual_odometry/painted_room.hpp>

#include <frugal_nav/Obstacle.h>
#include <frugal_nav/VoStatus.h>
#include <frugal_nav/odometry/visual_odometry.hpp>

namespace frugal_nav {
namespace {

using testing::HasSubstr;

const Pinhole kCamera{320, 240, 266.0, 266.0, 159.5, 119.5, 0.0, 0.0, 0.0, 0.0, 0.0};

/// A robot that drives through the painted room by wheels that do not err: odom is the room's frame.
class VisualOdometryNodeTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(graph_.clock.waitForNode("visual_odometry"));
    ASSERT_TRUE(status_.waitForPublisher() && points_.waitForPublisher() && odometry_.waitForPublisher());
    ASSERT_TRUE(graph_.connect());
    graph_.pose = {-2.2, -1.0, 0.3};
    graph_.clock.advance(0.1);
  }

  cv::Mat look() const { return room_.look(toIsometry(graph_.pose) * test::CameraGraph::mount(), kCamera); }

  /// The status that answers an image, sent with calibration and odometry of its stamp.
  const VoStatus* take(const sensor_msgs::Image& image) {
    graph_.publish(graph_.info());
    graph_.publishOdometry();
    graph_.publish(image);
    return test::answerAt(status_, image.header.stamp);
  }
  /// The same for what is seen 3 cm farther on.
  const VoStatus* step(const std::string& encoding = "mono8") {
    graph_.clock.advance(0.1);
    graph_.pose = graph_.pose * Pose2{0.03, 0.0, 0.0};
    cv::Mat image = look();
    if (encoding == "rgb8") cv::cvtColor(image, image, cv::COLOR_GRAY2RGB);
    if (encoding == "bgra8") cv::cvtColor(image, image, cv::COLOR_GRAY2BGRA);
    if (encoding == "mono16") image.convertTo(image, CV_16UC1, 257.0);
    return take(graph_.imageOf(image, encoding));
  }
  /// Drives until the map is there.
  bool driveUntilTracking() {
    for (int i = 0; i < 40; ++i) {
      const VoStatus* status = step();
      if (status != nullptr && status->state == VoStatus::STATE_TRACKING) return true;
    }
    return false;
  }

  test::CameraGraph graph_;
  PaintedRoom room_{500007};
  test::Recorder<VoStatus> status_{graph_.nh, "vo/status"};
  test::Recorder<nav_msgs::Odometry> odometry_{graph_.nh, "vo/odom"};
  test::Recorder<sensor_msgs::PointCloud2> points_{graph_.nh, "vo/points"};
};

TEST_F(VisualOdometryNodeTest, EachImageHasOneAnswerOfEachKind) {
  ASSERT_TRUE(driveUntilTracking());
  const std::size_t before = status_.messages.size();
  for (int i = 0; i < 5; ++i) ASSERT_NE(step(), nullptr);
  const ros::Time stamp = graph_.clock.now();
  const nav_msgs::Odometry* odometry = test::answerAt(odometry_, stamp);
  ASSERT_NE(odometry, nullptr);
  ASSERT_NE(test::answerAt(points_, stamp), nullptr);
  EXPECT_EQ(status_.messages.size(), before + 5);
  EXPECT_EQ(points_.messages.size(), status_.messages.size());
  EXPECT_EQ(odometry->header.frame_id, "odom");
  EXPECT_EQ(odometry->child_frame_id, "base_link");
  EXPECT_NEAR(odometry->pose.pose.position.x, graph_.pose.x_m, 0.03);
  EXPECT_NEAR(odometry->twist.twist.linear.x, 0.3, 0.05);
  EXPECT_GT(odometry->pose.covariance[0], 0.0);
}

TEST_F(VisualOdometryNodeTest, BroadcastsItsPoseWhenAskedTo) {  // publish_tf of the .test file
  tf2_ros::Buffer buffer;
  const tf2_ros::TransformListener listener(buffer);
  ASSERT_TRUE(driveUntilTracking());
  const auto known = [&] { return buffer.canTransform("odom", "base_link", graph_.clock.now()); };
  // The listener connects meanwhile.
  for (int i = 0; i < 20 && !test::waitUntil(known, 1.0); ++i) ASSERT_NE(step(), nullptr);
  ASSERT_TRUE(known());
  const nav_msgs::Odometry* odometry = test::answerAt(odometry_, graph_.clock.now());
  ASSERT_NE(odometry, nullptr);
  const auto transform = buffer.lookupTransform("odom", "base_link", graph_.clock.now()).transform;
  EXPECT_EQ(transform.translation.x, odometry->pose.pose.position.x);
  EXPECT_EQ(transform.rotation.z, odometry->pose.pose.orientation.z);
}

TEST_F(VisualOdometryNodeTest, PointsAreWhereTheirPixelsLook) {
  ASSERT_TRUE(driveUntilTracking());
  const sensor_msgs::PointCloud2* cloud = test::answerAt(points_, graph_.clock.now());
  ASSERT_NE(cloud, nullptr);
  EXPECT_EQ(cloud->header.frame_id, "odom");
  EXPECT_GT(cloud->width * cloud->height, 20U);
  const Eigen::Isometry3d optical_from_odom =
      (toIsometry(graph_.pose) * test::CameraGraph::mount()).inverse();
  sensor_msgs::PointCloud2ConstIterator<float> x(*cloud, "x");
  sensor_msgs::PointCloud2ConstIterator<float> u(*cloud, "u");
  sensor_msgs::PointCloud2ConstIterator<float> sigma(*cloud, "sigma");
  for (; x != x.end(); ++x, ++u, ++sigma) {
    const Eigen::Vector3d p = optical_from_odom * Eigen::Vector3f(x[0], x[1], x[2]).cast<double>();
    const auto pixel = kCamera.project(p);
    ASSERT_TRUE(pixel.has_value());
    // A point of the map fits to 2 px, or it is left out.
    EXPECT_LT((*pixel - Eigen::Vector2f(u[0], u[1]).cast<double>()).norm(), 2.1);
    EXPECT_GT(*sigma, 0.0F);
  }
}

TEST_F(VisualOdometryNodeTest, ColourAndDepthOfTheImageDoNotMatter) {
  ASSERT_TRUE(driveUntilTracking());
  for (const char* encoding : {"rgb8", "bgra8", "mono16", "mono8"}) {
    const VoStatus* status = step(encoding);
    ASSERT_NE(status, nullptr) << encoding;
    EXPECT_EQ(status->state, VoStatus::STATE_TRACKING) << encoding << ": " << status->reason;
  }
}

TEST_F(VisualOdometryNodeTest, BlackAndSaturatedImagesAreLostAndItRecovers) {
  ASSERT_TRUE(driveUntilTracking());
  for (const int level : {1, 255}) {
    graph_.clock.advance(0.1);
    const VoStatus* status = take(graph_.imageOf(cv::Mat(240, 320, CV_8UC1, cv::Scalar(level)), "mono8"));
    ASSERT_NE(status, nullptr);
    EXPECT_EQ(status->state, VoStatus::STATE_LOST);
    EXPECT_THAT(status->reason, HasSubstr(level == 1 ? "dark" : "saturated"));
    const sensor_msgs::PointCloud2* cloud = test::answerAt(points_, graph_.clock.now());
    ASSERT_NE(cloud, nullptr);
    EXPECT_EQ(cloud->width * cloud->height, 0U);
    EXPECT_TRUE(driveUntilTracking());
  }
}

TEST_F(VisualOdometryNodeTest, CorruptImageIsAnsweredWithItsFault) {
  ASSERT_TRUE(driveUntilTracking());
  graph_.clock.advance(0.1);
  sensor_msgs::Image image = graph_.imageOf(look(), "mono8");
  image.data.resize(100);
  const VoStatus* status = take(image);
  ASSERT_NE(status, nullptr);
  EXPECT_EQ(status->state, VoStatus::STATE_LOST);
  EXPECT_THAT(status->reason, HasSubstr("holds 100 bytes"));
  ASSERT_NE(test::answerAt(points_, graph_.clock.now()), nullptr);
  EXPECT_TRUE(driveUntilTracking());
}

TEST_F(VisualOdometryNodeTest, BlankCalibrationIsAnsweredAndASoundOneTakesOver) {
  graph_.clock.advance(0.1);
  sensor_msgs::CameraInfo blank = graph_.info();
  blank.K.fill(0.0);
  graph_.publish(blank);
  ASSERT_TRUE(test::waitUntil([&] {  // calibration and image come on different connections
    graph_.clock.advance(0.1);
    graph_.publishOdometry();
    graph_.publish(graph_.imageOf(look(), "mono8"));
    const VoStatus* status = test::answerAt(status_, graph_.clock.now());
    return status != nullptr && status->reason.find("calibrate") != std::string::npos;
  }));
  EXPECT_TRUE(driveUntilTracking());
}

TEST_F(VisualOdometryNodeTest, NearestObstaclesRegionIsSearched) {
  test::Recorder<Obstacle> found(graph_.nh, "vo/obstacle");
  ros::Publisher nearest = graph_.nh.advertise<Obstacle>("obstacle/nearest", 1);
  ASSERT_TRUE(found.waitForPublisher() && test::waitForSubscriber(nearest));
  ASSERT_TRUE(driveUntilTracking());
  Obstacle region;
  region.found = true;
  region.header.frame_id = "odom";
  region.region.x_offset = 60;
  region.region.y_offset = 40;
  region.region.width = 200;
  region.region.height = 180;
  const auto isFound = [&] {
    region.header.stamp = graph_.clock.now();
    nearest.publish(region);
    if (step() == nullptr) return false;
    const Obstacle* obstacle = test::answerAt(found, graph_.clock.now());
    return obstacle != nullptr && obstacle->found;
  };
  ASSERT_TRUE(test::waitUntil(isFound, 30.0)) << found.messages.back().reason;
  const Obstacle& obstacle = found.messages.back();
  EXPECT_EQ(obstacle.source, "vo");
  EXPECT_EQ(obstacle.region.width, 200U);
  // The wall ahead: somewhere between here and there, since a cluster's mean is the obstacle.
  EXPECT_GT(obstacle.distance_m, 0.5);
  EXPECT_LT(obstacle.distance_m, 6.0);
}

TEST_F(VisualOdometryNodeTest, MapGrowsOnTheRoomsWalls) {
  test::Recorder<sensor_msgs::PointCloud2> maps(graph_.nh, "vo/map");
  ASSERT_TRUE(maps.waitForPublisher());
  ASSERT_TRUE(driveUntilTracking());
  for (int i = 0; i < 80 && (maps.messages.empty() || maps.messages.back().width < 20U); ++i) step();
  ASSERT_FALSE(maps.messages.empty());
  const sensor_msgs::PointCloud2& map = maps.messages.back();
  ASSERT_GE(map.width, 20U);
  int off = 0;
  for (sensor_msgs::PointCloud2ConstIterator<float> x(map, "x"); x != x.end(); ++x) {
    const float nearest = std::min({std::abs(3.0F - std::abs(x[0])), std::abs(3.0F - std::abs(x[1])),
                                    std::abs(x[2]), std::abs(3.0F - x[2])});
    off += nearest > 0.3F ? 1 : 0;  // a tenth of the farthest distance in the room
  }
  EXPECT_LT(off, static_cast<int>(map.width) / 5);
}

TEST_F(VisualOdometryNodeTest, TimeJumpingBackStartsAnew) {
  ASSERT_TRUE(driveUntilTracking());
  graph_.clock.set(graph_.clock.now() - ros::Duration(20.0));
  status_.messages.clear();
  ASSERT_NE(step(), nullptr);
  EXPECT_EQ(status_.messages.back().state, VoStatus::STATE_INITIALIZING);
  EXPECT_TRUE(driveUntilTracking());
}

TEST(VisualOdometryNode, RefusesABadParameter) {
  const test::ProgramResult result =
      test::runProgram("visual_odometry_node", "__name:=visual_odometry_alone _features/method:=magic");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, testing::AllOf(HasSubstr("features/method"), HasSubstr("tracking")));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "visual_odometry_node_test");
  ros::NodeHandle nh;  // keeps ROS running between the tests
  return RUN_ALL_TESTS();
}
