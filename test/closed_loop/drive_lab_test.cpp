#include "support/ros_test.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <actionlib/client/simple_action_client.h>
#include <gtest/gtest.h>
#include <move_base_msgs/MoveBaseAction.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <std_msgs/UInt32.h>
#include <std_srvs/Trigger.h>

#include <frugal_nav/Contact.h>
#include <frugal_nav/LocalCommand.h>
#include <frugal_nav/MissionState.h>
#include <frugal_nav/SetSeed.h>
#include <frugal_nav/StepSimulation.h>
#include <frugal_nav/ros/conversions.hpp>

// The whole node graph drives through worlds/lab.world, in lock-step with the simulator.
namespace frugal_nav {
namespace {

using test::waitUntil;

constexpr Pose2 kWorldFromGoal{3.9, 1.9, 0.0};
constexpr double kGoalRadius_m = 0.30;
constexpr double kShortestDrive_m = 6.0;
constexpr double kLongestStart_s = 120.0;  // of wall time
constexpr double kLongestDrive_s = 90.0;   // three times what the way takes

class DriveLabTest : public testing::TestWithParam<int> {
 protected:
  /// The robot at its start in a world of that seed, and the graph ready for a goal; time stands. Empty, or
  /// what is missing.
  std::string prepare(int seed) {
    std_srvs::Trigger pause;
    if (!step_service_.waitForExistence(ros::Duration(30.0)) || !pause_service_.call(pause))
      return "no simulator";
    SetSeed request;
    request.request.seed = static_cast<std::uint64_t>(seed);
    if (!seed_service_.call(request) || !request.response.success)
      return "no seed: " + request.response.message;
    ready_ = false;
    truth_.reset();
    odometry_.reset();
    client_ = std::make_unique<Client>("move_base", false);
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(kLongestStart_s);
    while (!(ready_ && client_->isServerConnected() && truth_ && odometry_)) {
      StepSimulation step;
      step.request.seconds = 0.1;
      if (!step_service_.call(step)) return "no step";
      if (ros::WallTime::now() > end) return missing();
      ros::spinOnce();
    }
    contacts_ = 0;
    driven_m_ = 0.0;
    return "";
  }

  std::string missing() const {
    return !truth_                         ? "no ground_truth/odom"
           : !odometry_                    ? "no odom"
           : !client_->isServerConnected() ? "no server of move_base"
                                           : "avoidance/command is not idle";
  }

  /// Drives to the goal; how the action ended, or why it did not.
  std::string drive() {
    world_from_odom_ = *truth_ * odometry_->inverse();
    move_base_msgs::MoveBaseGoal goal;
    goal.target_pose.header.frame_id = "odom";
    goal.target_pose.pose = toRos(world_from_odom_.inverse() * kWorldFromGoal);
    client_->sendGoal(goal);
    if (!waitUntil([this] { return state_ == MissionState::STATE_DRIVING; })) return "no answer to the goal";
    start_ = ros::Time::now();
    std_srvs::Trigger resume;
    if (!resume_service_.call(resume)) return "no simulator";
    const auto elapsed_s = [this] { return (ros::Time::now() - start_).toSec(); };
    waitUntil([&] { return client_->getState().isDone() || elapsed_s() > kLongestDrive_s; }, 60.0);
    duration_s_ = elapsed_s();
    return client_->getState().isDone() ? client_->getState().toString() : "not there in time";
  }

  void onTruth(const nav_msgs::Odometry& msg) {
    const Pose2 pose = planar(msg.pose.pose).value();
    if (truth_) driven_m_ += distance(*truth_, pose);
    truth_ = pose;
  }

  void onContact(const Contact& contact) {
    ++contacts_;
    ADD_FAILURE() << contact.link << " touched " << contact.other;
  }

  using Client = actionlib::SimpleActionClient<move_base_msgs::MoveBaseAction>;
  ros::NodeHandle nh_;
  std::unique_ptr<Client> client_;
  std::optional<Pose2> truth_;     ///< world_from_base
  std::optional<Pose2> odometry_;  ///< odom_from_base
  Pose2 world_from_odom_;
  bool ready_ = false;  ///< planner and avoidance work, and wait for a goal
  int state_ = MissionState::STATE_IDLE;
  int contacts_ = 0;
  double driven_m_ = 0.0;
  ros::Time start_;
  double duration_s_ = 0.0;
  ros::ServiceClient step_service_ = nh_.serviceClient<StepSimulation>("simulator/step");
  ros::ServiceClient seed_service_ = nh_.serviceClient<SetSeed>("simulator/set_seed");
  ros::ServiceClient pause_service_ = nh_.serviceClient<std_srvs::Trigger>("simulator/pause");
  ros::ServiceClient resume_service_ = nh_.serviceClient<std_srvs::Trigger>("simulator/resume");
  ros::Subscriber truth_sub_ = nh_.subscribe("ground_truth/odom", 1000, &DriveLabTest::onTruth, this);
  ros::Subscriber contact_sub_ = nh_.subscribe("ground_truth/contact", 100, &DriveLabTest::onContact, this);
  ros::Subscriber odometry_sub_ = nh_.subscribe<nav_msgs::Odometry>(
      "odom", 1000,
      [this](const nav_msgs::OdometryConstPtr& msg) { odometry_ = planar(msg->pose.pose).value(); });
  ros::Subscriber state_sub_ = nh_.subscribe<MissionState>(
      "mission/state", 1000, [this](const MissionStateConstPtr& msg) { state_ = msg->state; });
  ros::Subscriber local_sub_ = nh_.subscribe<LocalCommand>(
      "avoidance/command", 100,
      [this](const LocalCommandConstPtr& msg) { ready_ = msg->status == LocalCommand::STATUS_IDLE; });
};

TEST_P(DriveLabTest, ReachesTheGoalWithoutAContact) {
  ASSERT_EQ(prepare(GetParam()), "");
  EXPECT_EQ(drive(), "SUCCEEDED") << client_->getState().getText();
  const double error_m = distance(*truth_, kWorldFromGoal);
  EXPECT_LE(error_m, kGoalRadius_m);
  EXPECT_EQ(contacts_, 0);
  EXPECT_GE(driven_m_, kShortestDrive_m);
  std::printf("seed %d: %.2f m in %.1f s, goal error %.2f m\n", GetParam(), driven_m_, duration_s_, error_m);
}

INSTANTIATE_TEST_SUITE_P(Seeds, DriveLabTest, testing::Values(1, 2, 3, 4, 5));

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "drive_lab_test");
  ros::NodeHandle nh;
  return RUN_ALL_TESTS();
}
