// Reads a drive toward a person back from a bag and runs visual odometry and the goal's detection over it, in
// this process, with the nodes' parameters: figures of the whole run, not of its last message.

#include "camera_drive_bag.hpp"

#include <map>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <rosbag/view.h>
#include <support/temp_folder.hpp>

#include <frugal_nav/odometry/visual_odometry.hpp>
#include <frugal_nav/perception/goal_finder.hpp>
#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/robot/robot_model.hpp>
#include <frugal_nav/ros/goal_detector_params.hpp>
#include <frugal_nav/ros/image_messages.hpp>
#include <frugal_nav/ros/visual_odometry_params.hpp>

namespace frugal_nav {
namespace {

const std::string kSource = FRUGAL_NAV_SOURCE_DIR;

/// One image of the bag with all that belongs to it.
struct BagFrame {
  Stamp stamp{};
  DecodedImage image;
  Calibration calibration;
  Pose2 odom_from_base;
  Pose2 truth;
};

std::vector<BagFrame> readFrames(const std::string& path) {
  rosbag::Bag bag(path);
  std::map<Stamp, BagFrame> frames;
  Calibration calibration;  // one for all: messages of one time come in any order
  for (const rosbag::MessageInstance& message : rosbag::View(bag, rosbag::TopicQuery("camera/camera_info")))
    calibration = fromRos(*message.instantiate<sensor_msgs::CameraInfo>());
  for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
    if (const auto image = message.instantiate<sensor_msgs::Image>()) {
      BagFrame& frame = frames[toStamp(image->header.stamp)];
      frame.stamp = toStamp(image->header.stamp);
      frame.image = decode(image);
      frame.calibration = fitTo(calibration, frame.image.bgr.cols, frame.image.bgr.rows);
    }
    if (const auto odometry = message.instantiate<nav_msgs::Odometry>()) {
      BagFrame& frame = frames[toStamp(odometry->header.stamp)];
      const Pose2 pose = fromRos(*odometry)->odom_from_base;
      (message.getTopic() == "odom" ? frame.odom_from_base : frame.truth) = pose;
    }
  }
  std::vector<BagFrame> ordered;
  for (const auto& [stamp, frame] : frames) ordered.push_back(frame);
  return ordered;
}

class CameraDriveBag : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const test::TempFolder folder;
    writeBag(folder.path("drive.bag"));
  }
  static void writeBag(const std::string& path) {
    test::writeCameraDriveBag(path);
    frames_ = readFrames(path);
  }
  void SetUp() override {
    ASSERT_GT(frames_.size(), 60U);  // 2 m at 0.3 m/s and 10 Hz
    for (const BagFrame& frame : frames_) {
      ASSERT_EQ(frame.image.fault, "");
      ASSERT_EQ(frame.calibration.fault, "");
    }
  }

  const Eigen::Isometry3d base_from_optical_ =
      loadRobot(kSource + "/urdf/frugal_bot.urdf").baseFrom("camera_optical_frame");
  static std::vector<BagFrame> frames_;
};

std::vector<BagFrame> CameraDriveBag::frames_;

TEST_F(CameraDriveBag, VisualOdometryFollowsTheTruth) {
  const auto params = loadParamFile<VisualOdometryNodeParams>(kSource + "/config/visual_odometry.yaml");
  VisualOdometry odometry(params.odometry, frames_.front().calibration.camera, base_from_optical_);
  int tracked = 0;
  int points = 0;
  double way_m = 0.0;
  double consistency = 0.0;  // normalised squared error of the position, summed
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const BagFrame& frame = frames_[i];
    if (i > 0) way_m += distance(frames_[i - 1].truth, frame.truth);
    VisualInput input;
    input.stamp = frame.stamp;
    input.image = frame.image.bgr;
    input.odom_from_base = toIsometry(frame.odom_from_base);
    const VisualOdometryOutput output = odometry.process(input);
    const Eigen::Vector2d error = output.odom_from_base.translation().head<2>() - frame.truth.position();
    // The wheels are uncalibrated and give the scale: 1.2 % of the way; as much again for the images, and 2
    // cm for the first start.
    ASSERT_LT(error.norm(), 0.02 + 0.024 * way_m) << "image " << i;
    if (output.status.state != VisualState::kTracking) continue;
    ++tracked;
    points += static_cast<int>(output.points.size());
    const Eigen::Matrix2d covariance = output.covariance.topLeftCorner<2, 2>();
    consistency += error.dot(covariance.inverse() * error);
  }
  ASSERT_GT(tracked, static_cast<int>(0.8 * static_cast<double>(frames_.size())));
  EXPECT_GT(points / tracked, 50);
  // Two degrees of freedom: 2 for a covariance that is right. One run is one sample of a slow drift: three
  // sigmas either way would be ten times that.
  EXPECT_LT(consistency / tracked, 20.0);
}

TEST_F(CameraDriveBag, GoalIsFoundAndKept) {
  const auto params = loadParamFile<GoalDetectorNodeParams>(kSource + "/config/goal_detector.yaml");
  GoalFinder finder(makeDetector(readParamFile(configOf(params.detector, kSource)), params.detector, kSource),
                    params.head, params.tracker);
  int seen = 0;
  std::optional<std::size_t> first;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const BagFrame& frame = frames_[i];
    const GoalFrame found = finder.look(
        {frame.stamp, frame.image.bgr, frame.calibration.camera, base_from_optical_, frame.odom_from_base});
    ASSERT_EQ(found.fault, "");
    if (!found.goal) continue;
    if (!first) first = i;
    seen += found.state == GoalTracker::State::kSeen ? 1 : 0;
    // A head's size differs by 5 % between people, an edge of its box by a pixel or two: 15 % of 5 m at most.
    EXPECT_LT((found.goal->p_odom - test::kPerson.position()).norm(), 0.75) << "image " << i;
  }
  ASSERT_TRUE(first.has_value());
  EXPECT_LT(*first, 20U);
  EXPECT_GT(seen, static_cast<int>(0.8 * static_cast<double>(frames_.size() - *first)));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
