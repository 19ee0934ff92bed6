// One list of bad input for every node that takes images: each image has its answer, diagnostics name the
// fault, and the node goes on once sound input is back.

#include "board_view.hpp"
#include "camera_graph.hpp"

#include <memory>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/Detection2DArray.h>
#include <frugal_nav/Gap.h>
#include <frugal_nav/VoStatus.h>
#include <frugal_nav/ros/depth_gap_node.hpp>
#include <frugal_nav/ros/goal_detector_node.hpp>
#include <frugal_nav/ros/visual_odometry_node.hpp>

namespace frugal_nav {
namespace {

/// The output of which a node publishes one message an image, and its words for an image without light.
template <class Node>
struct Output;
template <>
struct Output<GoalDetectorNode> {
  using Message = Detection2DArray;
  static constexpr const char* kTopic = "goal/detections";
  static constexpr const char* kBlack = "the image is black";
};
template <>
struct Output<VisualOdometryNode> {
  using Message = VoStatus;
  static constexpr const char* kTopic = "vo/status";
  static constexpr const char* kBlack = "dark";
};
template <>
struct Output<DepthGapNode> {
  using Message = Gap;
  static constexpr const char* kTopic = "gap";
  static constexpr const char* kBlack = "the image is black";
};

/// A node with its defaults in this process, which has seen nothing yet.
template <class Node>
class ImageNodesInput : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(answers_.waitForPublisher() && diagnostics_.waitForPublisher() && graph_.connect());
  }

  sensor_msgs::Image look(const std::string& encoding = "bgr8") const {
    cv::Mat image = view_;
    if (encoding == "mono8") cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
    if (encoding == "rgb8") cv::cvtColor(image, image, cv::COLOR_BGR2RGB);
    if (encoding == "bgra8") cv::cvtColor(image, image, cv::COLOR_BGR2BGRA);
    return graph_.imageOf(image, encoding);
  }
  /// A tenth of a second later: odometry and an image, the latter of `make`. Whether an answer comes, for
  /// which time may pass.
  template <class Make>
  bool show(Make make) {
    graph_.clock.advance(0.1);
    const sensor_msgs::Image image = make();
    if (info_) graph_.publish(*info_);
    graph_.publishOdometry();
    graph_.publish(image);
    ++images_;
    const auto isAnswered = [&] {
      return !answers_.messages.empty() && answers_.messages.back().header.stamp == image.header.stamp;
    };
    for (double passed_s = 0.0; passed_s < 1.0; passed_s += 0.05) {
      if (test::waitUntil(isAnswered, 0.02)) return true;
      graph_.clock.advance(0.05);
    }
    return false;
  }
  bool show() {
    return show([this] { return look(); });
  }

  /// Whether the node's newest report has the words.
  bool says(const std::string& words) const {
    if (diagnostics_.messages.empty()) return false;
    for (const auto& status : diagnostics_.messages.back().status) {
      if (status.message.find(words) != std::string::npos) return true;
    }
    return false;
  }
  /// Shows what `make` gives until the report has the words, or has them no more. Reports come once a second.
  template <class Make>
  void expectReport(const std::string& words, bool wanted, Make make) {
    diagnostics_.messages.clear();
    const auto isThere = [&] { return !diagnostics_.messages.empty() && says(words) == wanted; };
    for (int i = 0; i < 30 && !isThere(); ++i) ASSERT_TRUE(show(make)) << words;
    EXPECT_TRUE(isThere()) << (wanted ? "not said: " : "still said: ") << words;
  }
  /// Such images are reported with these words, and sound ones after them are taken.
  template <class Make>
  void expectFault(const std::string& words, Make make) {
    expectReport(words, true, make);
    expectRecovery(words);
  }
  void expectRecovery(const std::string& words) {
    info_ = graph_.info();
    expectReport(words, false, [this] { return look(); });
    EXPECT_EQ(answers_.messages.size(), images_);
  }
  /// What the node counts, as its report has it.
  std::string reported(const std::string& key) {
    diagnostics_.messages.clear();
    for (int i = 0; i < 30 && diagnostics_.messages.empty(); ++i) {
      if (!show()) break;
    }
    for (const auto& message : diagnostics_.messages) {
      for (const auto& value : message.status.at(0).values) {
        if (value.key == key) return value.value;
      }
    }
    return "not there";
  }

  test::CameraGraph graph_{"image_node"};
  const cv::Mat view_ = test::boardAhead();
  std::optional<sensor_msgs::CameraInfo> info_ = graph_.info();
  std::size_t images_ = 0;
  Node node_{graph_.nh, ros::NodeHandle("~image_node")};
  test::Recorder<typename Output<Node>::Message> answers_{graph_.nh, Output<Node>::kTopic};
  test::Recorder<diagnostic_msgs::DiagnosticArray> diagnostics_{graph_.nh, "/diagnostics"};
};

using ImageNodes = testing::Types<GoalDetectorNode, VisualOdometryNode, DepthGapNode>;
TYPED_TEST_SUITE(ImageNodesInput, ImageNodes, );

TYPED_TEST(ImageNodesInput, EncodingsAndSizesOfDriversAreTaken) {
  for (const char* encoding : {"mono8", "rgb8", "bgra8", "bgr8"})
    EXPECT_TRUE(this->show([&] { return this->look(encoding); })) << encoding;
  for (const int width : {160, 321, 640}) {
    cv::Mat resized;
    cv::resize(this->view_, resized, cv::Size(width, 3 * width / 4));
    EXPECT_TRUE(this->show([&] { return this->graph_.imageOf(resized); })) << width;
  }
  EXPECT_EQ(this->reported("camera/image_raw refused"), "0");
  EXPECT_EQ(this->reported("camera/image_raw dropped"), "0");
}

TYPED_TEST(ImageNodesInput, MissingCameraInfoIsNamed) {
  this->info_.reset();
  this->expectFault("no camera_info on /image_node/camera/camera_info", [this] { return this->look(); });
}

TYPED_TEST(ImageNodesInput, CameraInfoOfZerosSaysWhatToDo) {
  this->info_->K.fill(0.0);
  this->expectFault("calibrate the camera", [this] { return this->look(); });
}

TYPED_TEST(ImageNodesInput, CameraInfoOfAnotherShapeIsNamed) {
  ASSERT_TRUE(this->show());
  this->info_->height = 180;
  this->expectFault("the image is 320x240, but camera_info is for 320x180", [this] { return this->look(); });
}

TYPED_TEST(ImageNodesInput, BlackImagesAreNamed) {
  ASSERT_TRUE(this->show());
  this->expectFault(Output<TypeParam>::kBlack,
                    [this] { return this->graph_.imageOf(cv::Mat::zeros(240, 320, CV_8UC3)); });
}

TYPED_TEST(ImageNodesInput, SaturatedImagesAreNamed) {
  ASSERT_TRUE(this->show());
  const cv::Mat white(240, 320, CV_8UC3, cv::Scalar::all(255));
  this->expectFault("saturated", [&] { return this->graph_.imageOf(white); });
}

TYPED_TEST(ImageNodesInput, CutImagesAreNamed) {
  ASSERT_TRUE(this->show());
  this->expectFault("holds 100 bytes", [this] {
    sensor_msgs::Image image = this->look();
    image.data.resize(100);
    return image;
  });
}

TYPED_TEST(ImageNodesInput, DepthImagesAreNoPictures) {
  this->expectFault("is no picture",
                    [this] { return this->graph_.imageOf(cv::Mat(240, 320, CV_32FC1), "32FC1"); });
}

TYPED_TEST(ImageNodesInput, SilentCameraIsNamed) {
  ASSERT_TRUE(this->show());
  this->diagnostics_.messages.clear();
  const auto isSaid = [this] { return this->says("no image on /image_node/camera/image_raw"); };
  for (int i = 0; i < 100 && !isSaid(); ++i) {
    this->graph_.clock.advance(0.05);
    test::waitUntil(isSaid, 0.01);
  }
  EXPECT_TRUE(isSaid());
  this->expectRecovery("no image on");
}

TEST(GoalDetectorNode, ANetworkOfAnotherKindEndsItWithItsName) {
  const std::string file = std::string(FRUGAL_NAV_SOURCE_DIR) + "/models/depth_small.onnx";
  const test::ProgramResult result =
      test::runProgram("goal_detector_node", "__name:=goal_detector_alone _model_file:=" + file);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, testing::AllOf(testing::HasSubstr("FATAL"), testing::HasSubstr(file)));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "image_nodes_input_test");
  ros::NodeHandle nh;  // keeps ROS running between the tests
  return RUN_ALL_TESTS();
}
