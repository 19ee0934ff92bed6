#include "../../src/eval/onnx_writer.hpp"
#include "board_view.hpp"
#include "camera_graph.hpp"

#include <cmath>
#include <cstring>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <support/temp_folder.hpp>

#include <frugal_nav/Gap.h>
#include <frugal_nav/Obstacle.h>
#include <frugal_nav/eval/midas_sized_network.hpp>
#include <frugal_nav/ros/depth_gap_node.hpp>
#include <frugal_nav/ros/visual_messages.hpp>

namespace frugal_nav {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// A node of its own name, so that it takes no other's parameters.
const std::string kAlone = "__name:=depth_gap_alone ";

/// A camera before a board that stands on the floor.
class DepthGapNodeTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(graph_.clock.waitForNode("depth_gap"));
    ASSERT_TRUE(gaps_.waitForPublisher() && obstacles_.waitForPublisher() && scans_.waitForPublisher());
    ASSERT_TRUE(graph_.connect());
    static int tests = 0;  // each later than the one before: time does not jump back between them
    graph_.clock.set(ros::Time(200.0 * ++tests));
  }
  /// An image of the present time, with its calibration and odometry.
  void send(const sensor_msgs::Image& image) {
    graph_.publish(graph_.info());
    graph_.publishOdometry();
    graph_.publish(image);
  }
  const Obstacle* show(const cv::Mat& image, const std::string& encoding = "bgr8") {
    graph_.clock.advance(0.1);
    send(graph_.imageOf(image, encoding));
    return test::answerAt(obstacles_, graph_.clock.now());
  }

  test::CameraGraph graph_;
  const cv::Mat board_ = test::boardAhead();
  test::Recorder<Gap> gaps_{graph_.nh, "gap"};
  test::Recorder<Obstacle> obstacles_{graph_.nh, "obstacle/nearest"};
  test::Recorder<sensor_msgs::LaserScan> scans_{graph_.nh, "depth/scan"};
};

TEST_F(DepthGapNodeTest, EachImageHasAGapAnObstacleAndAScan) {
  for (int i = 0; i < 5; ++i) ASSERT_NE(show(board_), nullptr);
  const Obstacle* obstacle = &obstacles_.messages.back();
  const Gap* gap = test::answerAt(gaps_, graph_.clock.now());
  const sensor_msgs::LaserScan* scan = test::answerAt(scans_, graph_.clock.now());
  ASSERT_TRUE(gap != nullptr && scan != nullptr);
  EXPECT_EQ(obstacles_.messages.size(), 5U);
  EXPECT_EQ(gap->header.frame_id, "odom");
  EXPECT_EQ(scan->header.frame_id, "base_link");
  EXPECT_EQ(findFault(fromRos(*scan)), std::nullopt);
  // A cartoon is not what the network knows, but the floor's line is where it is.
  ASSERT_TRUE(obstacle->found) << obstacle->reason;
  EXPECT_NEAR(obstacle->distance_m, test::kBoard_m, 0.35);
  EXPECT_NEAR(obstacle->bearing_rad, 0.0, 0.15);
  EXPECT_TRUE(fromRos(*obstacle).has_value());
  EXPECT_TRUE(fromRos(*gap).has_value());
}

TEST_F(DepthGapNodeTest, TheOrderOfColoursDoesNotMatter) {
  test::Recorder<sensor_msgs::Image> inverse(graph_.nh, "depth/inverse");
  ASSERT_TRUE(inverse.waitForPublisher());
  ASSERT_NE(show(board_), nullptr);
  ASSERT_NE(test::answerAt(inverse, graph_.clock.now()), nullptr);
  const std::vector<std::uint8_t> wanted = inverse.messages.back().data;
  cv::Mat rgb;
  cv::cvtColor(board_, rgb, cv::COLOR_BGR2RGB);
  cv::Mat bgra;
  cv::cvtColor(board_, bgra, cv::COLOR_BGR2BGRA);
  const std::pair<std::string, cv::Mat> images[] = {{"rgb8", rgb}, {"bgra8", bgra}};
  for (const auto& [encoding, image] : images) {
    ASSERT_NE(show(image, encoding), nullptr) << encoding;
    ASSERT_NE(test::answerAt(inverse, graph_.clock.now()), nullptr) << encoding;
    EXPECT_TRUE(inverse.messages.back().data == wanted) << encoding;  // the same pixels, the same map
  }
  cv::Mat gray;
  cv::cvtColor(board_, gray, cv::COLOR_BGR2GRAY);
  const Obstacle* obstacle = show(gray, "mono8");
  ASSERT_NE(obstacle, nullptr);
  EXPECT_EQ(obstacle->reason, "");
}

TEST_F(DepthGapNodeTest, AResizedImageHasTheSameMetres) {
  test::Recorder<sensor_msgs::Image> metres(graph_.nh, "depth/image");
  ASSERT_TRUE(metres.waitForPublisher());
  for (const int scale : {1, 2}) {
    cv::Mat image;
    cv::resize(board_, image, cv::Size(), scale, scale, cv::INTER_NEAREST);
    for (int i = 0; i < 3; ++i) ASSERT_NE(show(image), nullptr);
    const sensor_msgs::Image* depth = test::answerAt(metres, graph_.clock.now());
    ASSERT_NE(depth, nullptr);
    EXPECT_EQ(depth->encoding, "32FC1");
    EXPECT_EQ(depth->header.frame_id, "camera_optical_frame");
    ASSERT_EQ(depth->width, static_cast<std::uint32_t>(image.cols));
    ASSERT_EQ(depth->data.size(), image.total() * sizeof(float));
    // Floor in the lower left corner: 106.4 / (row - 119.5), to the grid's row of two pixels.
    float depth_m = 0.0F;
    const std::size_t index = static_cast<std::size_t>(scale * (229 * image.cols + 30));
    std::memcpy(&depth_m, depth->data.data() + index * sizeof(float), sizeof(float));
    EXPECT_NEAR(depth_m, 106.4 / 109.5, 0.03) << scale;
  }
}

TEST_F(DepthGapNodeTest, UselessImagesHaveTheirReasonAndItRecovers) {
  ASSERT_NE(show(board_), nullptr);
  const std::pair<int, const char*> faults[] = {{0, "black"}, {255, "saturated"}};
  for (const auto& [level, words] : faults) {
    const Obstacle* obstacle = show(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(level)));
    ASSERT_NE(obstacle, nullptr);
    EXPECT_FALSE(obstacle->found);
    EXPECT_THAT(obstacle->reason, HasSubstr(words));
    const Gap* gap = test::answerAt(gaps_, graph_.clock.now());
    ASSERT_NE(gap, nullptr);
    EXPECT_FALSE(gap->found);
    EXPECT_EQ(gap->reason, obstacle->reason);
    const sensor_msgs::LaserScan* scan = test::answerAt(scans_, graph_.clock.now());
    ASSERT_NE(scan, nullptr);
    for (const float range : scan->ranges) EXPECT_TRUE(std::isnan(range));
  }
  const Obstacle* recovered = show(board_);
  ASSERT_NE(recovered, nullptr);
  EXPECT_TRUE(recovered->found);
}

TEST_F(DepthGapNodeTest, WaitsForThePointsOfTheImage) {
  ros::Publisher points_pub = graph_.nh.advertise<sensor_msgs::PointCloud2>("vo/points", 5);
  ASSERT_TRUE(test::waitForSubscriber(points_pub));
  graph_.clock.advance(0.1);
  const sensor_msgs::Image image = graph_.imageOf(board_);
  send(image);
  const auto isThere = [&] {
    return !obstacles_.messages.empty() && obstacles_.messages.back().header.stamp == image.header.stamp;
  };
  EXPECT_FALSE(test::waitUntil(isThere, 0.3));  // simulated time stands: it would wait for ever
  VisualOdometryOutput output;
  output.stamp = toStamp(image.header.stamp);
  output.is_metric = true;
  for (int i = 0; i < 20; ++i) {
    VisualPoint point;
    point.pixel = {132.0 + 3.0 * (i % 10), 100.0 + 20.0 * (i / 10)};
    point.p_camera =
        1.6 * Eigen::Vector3d((point.pixel.x() - 159.5) / 266.0, (point.pixel.y() - 119.5) / 266.0, 1.0);
    point.sigma_m = 0.02;
    output.points.push_back(point);
  }
  points_pub.publish(pointsMessage(output, test::CameraGraph::mount(), "odom"));
  ASSERT_TRUE(test::waitUntil(isThere));
  EXPECT_TRUE(obstacles_.messages.back().found);
  // Points that do not come are waited for no longer than vo_wait_s.
  graph_.clock.advance(0.1);
  const sensor_msgs::Image next = graph_.imageOf(board_);
  graph_.publish(next);
  graph_.publishOdometry();
  bool has_come = false;
  for (int i = 0; i < 10 && !has_come; ++i) {
    graph_.clock.advance(0.1);
    has_come =
        test::waitUntil([&] { return obstacles_.messages.back().header.stamp == next.header.stamp; }, 0.3);
  }
  EXPECT_TRUE(has_come);
}

TEST_F(DepthGapNodeTest, ThePersonWhoIsTheGoalIsNotTheNearest) {
  ros::Publisher goal_pub = graph_.nh.advertise<geometry_msgs::PoseWithCovarianceStamped>("goal/observed", 5);
  ASSERT_TRUE(test::waitForSubscriber(goal_pub));
  for (int i = 0; i < 3; ++i) ASSERT_NE(show(board_), nullptr);
  geometry_msgs::PoseWithCovarianceStamped goal;
  goal.header.stamp = graph_.clock.now();
  goal.header.frame_id = "odom";
  goal.pose.pose.position.x = 1.6;
  goal.pose.pose.position.z = 1.5;
  goal_pub.publish(goal);
  bool left_out = false;
  for (int i = 0; i < 10 && !left_out; ++i) {
    const Obstacle* obstacle = show(board_);
    ASSERT_NE(obstacle, nullptr);
    left_out = !obstacle->found || std::hypot(obstacle->point.x - 1.6, obstacle->point.y) > 0.4;
  }
  EXPECT_TRUE(left_out);
}

TEST_F(DepthGapNodeTest, ImagesAreForWhoLooks) {
  test::Recorder<sensor_msgs::Image> inverse(graph_.nh, "depth/inverse");
  test::Recorder<sensor_msgs::Image> debug(graph_.nh, "depth/debug_image");
  ASSERT_TRUE(inverse.waitForPublisher() && debug.waitForPublisher());
  ASSERT_NE(show(board_), nullptr);
  ASSERT_TRUE(inverse.waitForCount(1) && debug.waitForCount(1));
  EXPECT_EQ(inverse.messages[0].encoding, "32FC1");
  EXPECT_EQ(inverse.messages[0].width, 320U);
  EXPECT_EQ(debug.messages[0].encoding, "bgr8");
  EXPECT_EQ(debug.messages[0].header.frame_id, "camera_optical_frame");
}

TEST_F(DepthGapNodeTest, TimeJumpingBackIsSurvived) {
  ASSERT_NE(show(board_), nullptr);
  graph_.clock.set(graph_.clock.now() - ros::Duration(20.0));
  // The node may hear of the new time after an image of it, and forgets that one too.
  const auto isAnswered = [this] { return obstacles_.messages.back().header.stamp == graph_.clock.now(); };
  bool is_answered = false;
  for (int i = 0; i < 10 && !is_answered; ++i) {
    graph_.clock.advance(0.1);
    send(graph_.imageOf(board_));
    is_answered = test::waitUntil(isAnswered, 2.0);
  }
  ASSERT_TRUE(is_answered);
  EXPECT_EQ(obstacles_.messages.back().reason, "");
}

// The shapes of MiDaS v2.1 small, with random weights: what it says is no depth, but it runs through the
// whole node.
TEST(DepthGapNode, RunsANetworkOfMidasShapes) {
  const test::TempFolder folder;
  eval::writeMidasSizedNetwork(folder.path("model-small.onnx"));
  test::CameraGraph graph("midas");
  ros::NodeHandle pnh("~midas");
  pnh.setParam("model", "midas_v21_small");
  pnh.setParam("models_folder", folder.path());
  pnh.setParam("use_vo", false);
  const DepthGapNode node(graph.nh, pnh);
  test::Recorder<Gap> gaps(graph.nh, "gap");
  test::Recorder<sensor_msgs::LaserScan> scans(graph.nh, "depth/scan");
  ASSERT_TRUE(gaps.waitForPublisher() && scans.waitForPublisher() && graph.connect());
  for (int i = 0; i < 3; ++i) {
    graph.clock.advance(0.1);
    const sensor_msgs::Image image = graph.imageOf(test::boardAhead());
    graph.publish(graph.info());
    graph.publishOdometry();
    graph.publish(image);
    const Gap* gap = test::answerAt(gaps, image.header.stamp);
    ASSERT_NE(gap, nullptr);
    EXPECT_TRUE(gap->found || !gap->reason.empty());
    const sensor_msgs::LaserScan* scan = test::answerAt(scans, image.header.stamp);
    ASSERT_NE(scan, nullptr);
    for (const float range : scan->ranges) EXPECT_FALSE(range < scan->range_min);
  }
}

TEST(DepthGapNode, MissingModelEndsItWithWhatToDo) {
  const test::ProgramResult result =
      test::runProgram("depth_gap_node", kAlone + "_model_file:=/nowhere/midas.onnx");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output,
              AllOf(HasSubstr("FATAL"), HasSubstr("/nowhere/midas.onnx"), HasSubstr("put the model there")));
}

TEST(DepthGapNode, CorruptModelEndsItWithItsName) {
  const test::TempFolder folder;
  const std::string broken = folder.write("broken.onnx", "this is no network");
  const test::ProgramResult result = test::runProgram("depth_gap_node", kAlone + "_model_file:=" + broken);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, AllOf(HasSubstr("FATAL"), HasSubstr("broken.onnx")));
}

TEST(DepthGapNode, NetworkOfAnotherShapeEndsItWithItsShape) {
  eval::OnnxWriter writer({3, 256, 256});
  writer.finish(writer.convolve(writer.input(), {2, 1, 1, false}, {1, 0, 0, 0, 1, 0}));
  const test::TempFolder folder;
  const std::string file = folder.write("two_maps.onnx", writer.bytes());
  const test::ProgramResult result =
      test::runProgram("depth_gap_node", kAlone + "_model:=midas_v21_small _model_file:=" + file);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, AllOf(HasSubstr("FATAL"), HasSubstr("two_maps.onnx"), HasSubstr("1x2x256x256")));
}

TEST(DepthGapNode, UnknownModelAndBadParametersEndIt) {
  const test::ProgramResult unknown = test::runProgram("depth_gap_node", kAlone + "_model:=midaz");
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, HasSubstr("config/models/midaz.yaml"));
  const test::ProgramResult bad = test::runProgram("depth_gap_node", kAlone + "_grid_width_px:=3");
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_THAT(bad.output, HasSubstr("grid_width_px"));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "depth_gap_node_test");
  ros::NodeHandle nh;  // keeps ROS running between the tests
  return RUN_ALL_TESTS();
}
