#include "camera_graph.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <support/shared_data.hpp>
#include <support/temp_folder.hpp>
#include <unit/perception/drawn_face.hpp>

#include <frugal_nav/Detection2DArray.h>
#include <frugal_nav/ros/goal_detector_node.hpp>

namespace frugal_nav {
namespace {

using geometry_msgs::PoseWithCovarianceStamped;
using testing::AllOf;
using testing::HasSubstr;

/// A node of its own name, so that it takes no other's parameters.
const std::string kAlone = "__name:=goal_detector_alone ";

const cv::Mat kNobody(480, 640, CV_8UC3, cv::Scalar(150, 160, 165));

/// Somebody's face in front of a camera that is level, 0.4 m above the floor.
class GoalDetectorNodeTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(graph_.clock.waitForNode("goal_detector"));
    ASSERT_TRUE(detections_.waitForPublisher() && observed_.waitForPublisher());
    ASSERT_TRUE(graph_.connect());
    static int tests = 0;  // each so much later that the goal of the one before is forgotten
    graph_.clock.set(ros::Time(200.0 * ++tests));
  }

  /// The answer to an image of the present time, sent with its calibration and odometry.
  const Detection2DArray* take(const sensor_msgs::Image& image) {
    graph_.publish(graph_.info());
    graph_.publishOdometry();
    graph_.publish(image);
    return test::answerAt(detections_, image.header.stamp);
  }
  const Detection2DArray* show(const cv::Mat& image, const std::string& encoding = "bgr8") {
    graph_.clock.advance(0.1);
    return take(graph_.imageOf(image, encoding));
  }
  /// Shows the face until it has become the goal.
  bool showUntilObserved() {
    for (int i = 0; i < 10; ++i) {
      if (show(face_) == nullptr) return false;
      const ros::Time now = graph_.clock.now();
      const auto isThere = [&] {
        return !observed_.messages.empty() && observed_.messages.back().header.stamp == now;
      };
      if (test::waitUntil(isThere, i < 2 ? 0.05 : 1.0)) return true;
    }
    return false;
  }

  test::CameraGraph graph_;
  const cv::Mat face_ = test::drawnFace();
  test::Recorder<Detection2DArray> detections_{graph_.nh, "goal/detections"};
  test::Recorder<PoseWithCovarianceStamped> observed_{graph_.nh, "goal/observed"};
};

TEST_F(GoalDetectorNodeTest, EachImageHasOneAnswer) {
  ASSERT_NE(show(kNobody), nullptr);
  EXPECT_TRUE(detections_.messages.back().detections.empty());
  const Detection2DArray* found = show(face_);
  ASSERT_NE(found, nullptr);
  ASSERT_EQ(found->detections.size(), 1U);
  EXPECT_EQ(found->detections[0].label, "face");
  EXPECT_EQ(found->image_width, 640U);
  EXPECT_EQ(found->header.frame_id, "camera_optical_frame");
  EXPECT_EQ(detections_.messages.size(), 2U);
}

TEST_F(GoalDetectorNodeTest, GoalIsWhereTheFaceIs) {
  graph_.pose = {1.0, 2.0, M_PI / 2};
  ASSERT_TRUE(showUntilObserved());
  const Detection2DArray* found = test::answerAt(detections_, graph_.clock.now());
  ASSERT_NE(found, nullptr);
  const PoseWithCovarianceStamped& goal = observed_.messages.back();
  EXPECT_EQ(goal.header.frame_id, "odom");
  // Z = f H / h, ahead of the robot, which looks along odom's y; the robot's head_height_m is 0.232.
  const double ahead_m = 532.0 * 0.232 / found->detections[0].height;
  EXPECT_NEAR(goal.pose.pose.position.x, 1.0, 0.05);
  EXPECT_NEAR(goal.pose.pose.position.y, 2.0 + ahead_m, 0.05);
  EXPECT_GT(goal.pose.covariance[7], goal.pose.covariance[0]);  // the distance is the less sure
  EXPECT_GT(goal.pose.covariance[0], 0.0);
}

TEST_F(GoalDetectorNodeTest, NothingIsObservedWhileNothingIsSeen) {
  ASSERT_TRUE(showUntilObserved());
  const std::size_t before = observed_.messages.size();
  for (int i = 0; i < 5; ++i) ASSERT_NE(show(kNobody), nullptr);
  EXPECT_EQ(observed_.messages.size(), before);
  EXPECT_TRUE(showUntilObserved());
}

TEST_F(GoalDetectorNodeTest, ColourAndDepthOfTheImageDoNotMatter) {
  cv::Mat gray;
  cv::cvtColor(face_, gray, cv::COLOR_BGR2GRAY);
  cv::Mat gray16;
  gray.convertTo(gray16, CV_16UC1, 257.0);
  cv::Mat rgb;
  cv::cvtColor(face_, rgb, cv::COLOR_BGR2RGB);
  cv::Mat bgra;
  cv::cvtColor(face_, bgra, cv::COLOR_BGR2BGRA);
  const std::pair<std::string, cv::Mat> images[] = {
      {"mono8", gray}, {"mono16", gray16}, {"rgb8", rgb}, {"bgra8", bgra}};
  for (const auto& [encoding, image] : images) {
    const Detection2DArray* found = show(image, encoding);
    ASSERT_NE(found, nullptr) << encoding;
    EXPECT_EQ(found->detections.size(), 1U) << encoding;
  }
}

TEST_F(GoalDetectorNodeTest, UselessImagesHaveAnEmptyAnswerAndItRecovers) {
  ASSERT_TRUE(showUntilObserved());
  const std::size_t before = observed_.messages.size();
  for (const int level : {0, 255}) {
    const Detection2DArray* answer = show(cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(level)));
    ASSERT_NE(answer, nullptr);
    EXPECT_TRUE(answer->detections.empty());
  }
  graph_.clock.advance(0.1);
  sensor_msgs::Image corrupt = graph_.imageOf(face_);
  corrupt.data.resize(1000);
  const Detection2DArray* answer = take(corrupt);
  ASSERT_NE(answer, nullptr);
  EXPECT_TRUE(answer->detections.empty());
  EXPECT_EQ(observed_.messages.size(), before);
  EXPECT_TRUE(showUntilObserved());
}

TEST_F(GoalDetectorNodeTest, DiagnosticsNameTheFault) {
  test::Recorder<diagnostic_msgs::DiagnosticArray> diagnostics(graph_.nh, "/diagnostics");
  ASSERT_TRUE(diagnostics.waitForPublisher());
  const auto isNamed = [&] {
    for (const auto& message : diagnostics.messages) {
      for (const auto& status : message.status) {
        if (status.level == 1 && status.message.find("the image is black") != std::string::npos) return true;
      }
    }
    return false;
  };
  for (int i = 0; i < 40 && !isNamed(); ++i) ASSERT_NE(show(cv::Mat::zeros(480, 640, CV_8UC3)), nullptr);
  EXPECT_TRUE(isNamed());
}

TEST_F(GoalDetectorNodeTest, DebugImageIsForWhoLooks) {
  test::Recorder<sensor_msgs::Image> debug(graph_.nh, "goal/debug_image");
  ASSERT_TRUE(debug.waitForPublisher());
  ASSERT_NE(show(face_), nullptr);
  ASSERT_TRUE(debug.waitForCount(1));
  EXPECT_EQ(debug.messages[0].encoding, "bgr8");
  EXPECT_EQ(debug.messages[0].width, 640U);
  const std::vector<std::uint8_t> plain(face_.data, face_.data + face_.total() * 3);
  EXPECT_NE(debug.messages[0].data, plain);
}

TEST_F(GoalDetectorNodeTest, TimeJumpingBackForgetsTheGoal) {
  ASSERT_TRUE(showUntilObserved());
  graph_.clock.set(graph_.clock.now() - ros::Duration(10.0));
  observed_.messages.clear();
  ASSERT_NE(show(face_), nullptr);
  EXPECT_FALSE(
      test::waitUntil([this] { return !observed_.messages.empty(); }, 0.1));  // one sighting is no goal
  EXPECT_TRUE(showUntilObserved());
}

TEST(GoalDetectorNode, MissingModelEndsItWithWhatToDo) {
  const test::ProgramResult result =
      test::runProgram("goal_detector_node", kAlone + "_model_file:=/nowhere/heads.onnx");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output,
              AllOf(HasSubstr("FATAL"), HasSubstr("/nowhere/heads.onnx"), HasSubstr("put the model there")));
}

TEST(GoalDetectorNode, CorruptModelEndsItWithItsName) {
  const test::TempFolder folder;
  const std::string broken = folder.write("broken.onnx", "this is no network");
  const test::ProgramResult result =
      test::runProgram("goal_detector_node", kAlone + "_model_file:=" + broken);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, AllOf(HasSubstr("FATAL"), HasSubstr("broken.onnx")));
}

TEST(GoalDetectorNode, UnknownModelNameEndsIt) {
  const test::ProgramResult result = test::runProgram("goal_detector_node", kAlone + "_model:=heds");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("config/models/heds.yaml"));
}

TEST(GoalDetectorNode, UnknownLabelEndsIt) {
  const test::ProgramResult result = test::runProgram("goal_detector_node", kAlone + "_wanted:='[hed]'");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("hed"));
}

/// A published network on a photograph, through the node's own class.
class RealDetectors : public testing::TestWithParam<const char*> {};

TEST_P(RealDetectors, FindThePersonInThePhotograph) {
  if (test::sharedModels().empty()) GTEST_SKIP() << "no ../shared/data/models beside the source tree";
  const std::string name = GetParam();
  test::CameraGraph graph(name);
  ros::NodeHandle pnh("~" + name);
  pnh.setParam("model", name);
  pnh.setParam("models_folder", test::sharedModels());
  const GoalDetectorNode node(graph.nh, pnh);
  test::Recorder<Detection2DArray> detections(graph.nh, "goal/detections");
  ASSERT_TRUE(detections.waitForPublisher() && graph.connect());
  const cv::Mat photograph = cv::imread(test::sharedModels() + "/person.jpg");
  graph.clock.advance(0.1);
  sensor_msgs::CameraInfo info = graph.info();
  info.width = static_cast<std::uint32_t>(photograph.cols);
  info.height = static_cast<std::uint32_t>(photograph.rows);
  const sensor_msgs::Image image = graph.imageOf(photograph);
  graph.publish(info);
  graph.publishOdometry();
  graph.publish(image);
  const Detection2DArray* answer = test::answerAt(detections, image.header.stamp);
  ASSERT_NE(answer, nullptr);
  if (name == "yunet") return;  // the person's face is turned away: that it runs is all there is to see
  ASSERT_FALSE(answer->detections.empty());
  EXPECT_EQ(answer->detections[0].label, "person");
  // The person stands at (192..274, 99..374), measured by eye to a few pixels.
  EXPECT_NEAR(answer->detections[0].x, 192.0, 12.0);
  EXPECT_NEAR(answer->detections[0].height, 275.0, 20.0);
}

INSTANTIATE_TEST_SUITE_P(GoalDetector, RealDetectors, testing::Values("yolox_nano", "yolo_fastest", "yunet"),
                         [](const auto& name) { return std::string(name.param); });

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "goal_detector_node_test");
  ros::NodeHandle nh;  // keeps ROS running between the tests
  return RUN_ALL_TESTS();
}
