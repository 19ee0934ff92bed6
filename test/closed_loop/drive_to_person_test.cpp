#include "support/ros_test.hpp"

#include <cmath>
#include <optional>
#include <string>

#include <geometry_msgs/TwistStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>

#include <frugal_nav/Contact.h>
#include <frugal_nav/MissionState.h>
#include <frugal_nav/ros/conversions.hpp>

// The node graph of hybrid.launch drives to a person in worlds/lab_visit.world, in lock-step with the
// simulator: images in, wheel speeds out.
namespace frugal_nav {
namespace {

using test::waitUntil;

const Eigen::Vector2d kStart(-4.0, -2.4);
const Eigen::Vector2d kPerson(0.75, -2.2);
constexpr double kStandOff_m = 0.8;
constexpr double kGoalRadius_m = 0.30;
constexpr double kShortestDrive_m = 3.0;
constexpr double kLongestWait_s = 160.0;  // of wall time

class DriveToPersonTest : public testing::Test {
 protected:
  bool isDone() const { return state_ && state_->state >= MissionState::STATE_REACHED; }

  void onTruth(const nav_msgs::Odometry& msg) {
    const Pose2 pose = planar(msg.pose.pose).value();
    if (truth_) driven_m_ += distance(*truth_, pose);
    truth_ = pose;
  }
  void onContact(const Contact& contact) { ADD_FAILURE() << contact.link << " touched " << contact.other; }

  ros::NodeHandle nh_;
  std::optional<Pose2> truth_;  ///< world_from_base
  std::optional<MissionState> state_;
  double driven_m_ = 0.0;
  int moving_commands_ = 0;
  ros::Subscriber truth_sub_ = nh_.subscribe("ground_truth/odom", 1000, &DriveToPersonTest::onTruth, this);
  ros::Subscriber contact_sub_ =
      nh_.subscribe("ground_truth/contact", 100, &DriveToPersonTest::onContact, this);
  ros::Subscriber state_sub_ = nh_.subscribe<MissionState>(
      "mission/state", 1000, [this](const MissionStateConstPtr& msg) { state_ = *msg; });
  ros::Subscriber command_sub_ = nh_.subscribe<geometry_msgs::TwistStamped>(
      "cmd_vel_stamped", 1000, [this](const geometry_msgs::TwistStampedConstPtr& msg) {
        moving_commands_ += msg->twist.linear.x > 0.0 ? 1 : 0;
      });
};

TEST_F(DriveToPersonTest, StopsBeforeThePersonWithoutAContact) {
  ASSERT_TRUE(waitUntil([this] { return isDone(); }, kLongestWait_s))
      << (state_ ? state_->reason : "no mission/state");
  EXPECT_EQ(static_cast<int>(state_->state), static_cast<int>(MissionState::STATE_REACHED)) << state_->reason;
  const Eigen::Vector2d stand_off = kPerson - kStandOff_m * (kPerson - kStart).normalized();
  const double error_m = (truth_->position() - stand_off).norm();
  EXPECT_LE(error_m, kGoalRadius_m);
  EXPECT_GE(driven_m_, kShortestDrive_m);
  EXPECT_GT(moving_commands_, 0);
  std::printf("%.2f m driven, error %.2f m\n", driven_m_, error_m);
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "drive_to_person_test");
  ros::NodeHandle nh;
  return RUN_ALL_TESTS();
}
