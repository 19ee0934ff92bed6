#include "camera_graph.hpp"

#include <deque>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <std_msgs/Empty.h>

#include <frugal_nav/ros/image_intake.hpp>

namespace frugal_nav {
namespace {

using testing::HasSubstr;

/// An intake within this process, and someone who listens to its owner.
class ImageIntakeTest : public testing::Test {
 protected:
  void listen() {
    listener_ = graph_.nh.subscribe<std_msgs::Empty>(
        "output", 1, +[](const std_msgs::EmptyConstPtr&) {});
    ASSERT_TRUE(graph_.connect());
  }
  void SetUp() override { listen(); }

  /// A tenth of a second later: odometry, calibration and an image.
  const CameraFrame* beat(const sensor_msgs::Image& image) {
    graph_.publish(graph_.info());
    graph_.publishOdometry();
    graph_.publish(image);
    return frameAt(image.header.stamp);
  }
  const CameraFrame* beat() {
    graph_.clock.advance(0.1);
    return beat(graph_.imageOf(picture_));
  }
  /// Waits for the frame of that stamp.
  const CameraFrame* frameAt(ros::Time stamp) {
    const CameraFrame* found = nullptr;
    test::waitUntil(
        [&] {
          for (const CameraFrame& frame : frames_) found = frame.stamp == toStamp(stamp) ? &frame : found;
          return found != nullptr;
        },
        5.0);
    return found;
  }
  /// Lets ROS time pass until the frame of that stamp is there.
  const CameraFrame* frameInTime(ros::Time stamp, double most_s) {
    for (double passed_s = 0.0; passed_s < most_s; passed_s += 0.05) {
      graph_.clock.advance(0.05);
      test::waitUntil([] { return false; }, 0.02);
      for (const CameraFrame& frame : frames_) {
        if (frame.stamp == toStamp(stamp)) return &frame;
      }
    }
    return nullptr;
  }

  test::CameraGraph graph_;
  const cv::Mat picture_{240, 320, CV_8UC3, cv::Scalar(10, 20, 30)};
  std::deque<CameraFrame> frames_;
  int jumps_ = 0;
  bool is_ready_ = true;
  NodeDiagnostics diagnostics_{graph_.nh, ros::NodeHandle("~")};
  ImageIntake intake_{
      graph_.nh, ImageIntakeParams(), diagnostics_,
      ImageIntake::Callbacks{[this](const CameraFrame& frame) { frames_.push_back(frame); },
                             [this] { ++jumps_; }, [this](const CameraFrame&) { return is_ready_; }}};
  ros::Publisher output_ = intake_.advertise<std_msgs::Empty>("output", 1);
  ros::Subscriber listener_;
};

TEST_F(ImageIntakeTest, FrameKnowsHowItWasTaken) {
  graph_.pose = {1.0, 2.0, 0.5};
  const CameraFrame* frame = beat();
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->fault, "");
  EXPECT_EQ(frame->bgr.at<cv::Vec3b>(5, 7), cv::Vec3b(10, 20, 30));
  EXPECT_EQ(frame->camera.fx, 266.0);
  EXPECT_NEAR(frame->base_from_optical.translation().z(), 0.4, 1e-9);
  EXPECT_NEAR((frame->base_from_optical.linear() * Eigen::Vector3d::UnitZ()).x(), 1.0, 1e-9);
  EXPECT_NEAR(frame->odometry.odom_from_base.x_m, 1.0, 1e-9);
  EXPECT_EQ(frames_.size(), 1U);
}

TEST_F(ImageIntakeTest, TakesImagesOnlyWhileSomeoneListens) {
  ASSERT_NE(beat(), nullptr);
  listener_.shutdown();
  EXPECT_TRUE(test::waitUntil([this] { return graph_.imageListeners() == 0; }));
  listen();
  EXPECT_NE(beat(), nullptr);
}

TEST_F(ImageIntakeTest, ImageWaitsForOdometryOfItsStamp) {
  ASSERT_NE(beat(), nullptr);
  graph_.clock.advance(0.1);
  const sensor_msgs::Image image = graph_.imageOf(picture_);
  graph_.publish(image);
  EXPECT_FALSE(test::waitUntil([this] { return frames_.size() > 1; }, 0.2));  // wall time: none may come
  graph_.publishOdometry();
  const CameraFrame* frame = frameAt(image.header.stamp);
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->fault, "");
}

TEST_F(ImageIntakeTest, LostOdometryIsAFaultOnce) {
  ASSERT_NE(beat(), nullptr);
  graph_.clock.advance(0.1);
  const sensor_msgs::Image image = graph_.imageOf(picture_);
  graph_.publish(image);
  const CameraFrame* frame = frameInTime(image.header.stamp, 2.0);
  ASSERT_NE(frame, nullptr);
  EXPECT_THAT(frame->fault, HasSubstr("no odometry"));
  graph_.publishOdometry();
  ASSERT_NE(beat(), nullptr);  // and it goes on
  EXPECT_EQ(frames_.back().fault, "");
  EXPECT_EQ(frames_.size(), 3U);
}

TEST_F(ImageIntakeTest, MissingCameraInfoIsAFaultThatNamesTheTopic) {
  graph_.clock.advance(0.1);
  const sensor_msgs::Image image = graph_.imageOf(picture_);
  graph_.publishOdometry();
  graph_.publish(image);
  const CameraFrame* frame = frameInTime(image.header.stamp, 2.0);
  ASSERT_NE(frame, nullptr);
  EXPECT_THAT(frame->fault, HasSubstr("camera/camera_info"));
  ASSERT_NE(beat(), nullptr);
  EXPECT_EQ(frames_.back().fault, "");
}

TEST_F(ImageIntakeTest, BlankCameraInfoSaysWhatToDo) {
  graph_.clock.advance(0.1);
  sensor_msgs::CameraInfo blank = graph_.info();
  blank.K.fill(0.0);
  const sensor_msgs::Image image = graph_.imageOf(picture_);
  graph_.publish(blank);
  graph_.publishOdometry();
  graph_.publish(image);
  const CameraFrame* frame = frameInTime(image.header.stamp, 2.0);
  ASSERT_NE(frame, nullptr);
  EXPECT_THAT(frame->fault, HasSubstr("calibrate"));
}

TEST_F(ImageIntakeTest, EveryKindOfBadImageIsOneFaultAndTheNextIsSound) {
  ASSERT_NE(beat(), nullptr);
  const auto expectFault = [this](sensor_msgs::Image image, const std::string& what) {
    image.header.stamp = graph_.clock.now();
    const std::size_t before = frames_.size();
    const CameraFrame* frame = beat(image);
    ASSERT_NE(frame, nullptr) << what;
    EXPECT_THAT(frame->fault, HasSubstr(what));
    ASSERT_NE(beat(), nullptr);
    EXPECT_EQ(frames_.back().fault, "") << what;
    EXPECT_EQ(frames_.size(), before + 2);
    graph_.clock.advance(0.1);
  };
  graph_.clock.advance(0.1);
  sensor_msgs::Image image = graph_.imageOf(picture_);
  image.data.resize(1000);
  expectFault(image, "holds 1000 bytes");
  image = graph_.imageOf(picture_, "holograph");
  expectFault(image, "holograph");
  const cv::Mat floats(240, 320, CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  expectFault(graph_.imageOf(floats, "32FC1"), "32FC1");
  expectFault(graph_.imageOf(cv::Mat(240, 240, CV_8UC3)), "240x240");
  image = graph_.imageOf(picture_);
  image.header.frame_id = "";
  expectFault(image, "no frame");
}

TEST_F(ImageIntakeTest, UnknownFrameIsAFault) {
  ASSERT_NE(beat(), nullptr);
  graph_.clock.advance(0.1);
  sensor_msgs::Image image = graph_.imageOf(picture_);
  image.header.frame_id = "attic";
  graph_.publishOdometry();
  graph_.publish(image);
  const CameraFrame* frame = frameInTime(image.header.stamp, 2.0);
  ASSERT_NE(frame, nullptr);
  EXPECT_THAT(frame->fault, HasSubstr("no transform from base_link to attic"));
}

TEST_F(ImageIntakeTest, ResizedImageHasAScaledCamera) {
  ASSERT_NE(beat(), nullptr);
  graph_.clock.advance(0.1);
  const CameraFrame* frame = beat(graph_.imageOf(cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(50))));
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->fault, "");
  EXPECT_DOUBLE_EQ(frame->camera.fx, 532.0);
}

TEST_F(ImageIntakeTest, OwnerMayHoldAnImageBack) {
  ASSERT_NE(beat(), nullptr);
  is_ready_ = false;
  graph_.clock.advance(0.1);
  graph_.publishOdometry();
  graph_.publish(graph_.imageOf(picture_));
  EXPECT_FALSE(test::waitUntil([this] { return frames_.size() > 1; }, 0.2));
  is_ready_ = true;
  intake_.process();
  EXPECT_EQ(frames_.size(), 2U);
}

TEST_F(ImageIntakeTest, TimeJumpingBackIsToldOnceAndForgotten) {
  ASSERT_NE(beat(), nullptr);
  const ros::Time before = graph_.clock.now();
  graph_.clock.set(before - ros::Duration(5.0));
  ASSERT_NE(beat(), nullptr);
  EXPECT_EQ(frames_.back().fault, "");
  EXPECT_EQ(jumps_, 1);
}

TEST_F(ImageIntakeTest, SameStampTwiceIsOneFrame) {
  ASSERT_NE(beat(), nullptr);
  graph_.publish(graph_.imageOf(picture_));
  ASSERT_NE(beat(), nullptr);
  EXPECT_EQ(frames_.size(), 2U);
}

TEST_F(ImageIntakeTest, SilentCameraShowsInDiagnostics) {
  ros::NodeHandle nh;
  test::Recorder<diagnostic_msgs::DiagnosticArray> diagnostics(nh, "/diagnostics");
  ASSERT_TRUE(diagnostics.waitForPublisher());
  ASSERT_NE(beat(), nullptr);
  const auto saysSilent = [&] {
    for (const auto& message : diagnostics.messages) {
      for (const auto& status : message.status) {
        if (status.message.find("no image on") != std::string::npos) return true;
      }
    }
    return false;
  };
  for (int i = 0; i < 100 && !saysSilent(); ++i) {
    graph_.clock.advance(0.05);
    test::waitUntil([] { return false; }, 0.01);
  }
  EXPECT_TRUE(saysSilent());
}

TEST(ImageIntake, UnknownTransportIsAConfigurationError) {
  ros::NodeHandle nh;
  NodeDiagnostics diagnostics(nh, ros::NodeHandle("~"));
  ImageIntakeParams params;
  params.image_transport = "pigeon";
  try {
    ImageIntake intake(nh, params, diagnostics, {});
    FAIL() << "no ConfigError";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("pigeon"), HasSubstr("raw")));
  }
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "image_intake_test");
  ros::NodeHandle nh;
  return RUN_ALL_TESTS();
}
