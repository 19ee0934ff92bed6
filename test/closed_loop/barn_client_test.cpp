#include "support/ros_test.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include <actionlib/client/simple_action_client.h>
#include <gtest/gtest.h>
#include <move_base_msgs/MoveBaseAction.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>

#include <frugal_nav/Contact.h>
#include <frugal_nav/LocalCommand.h>
#include <frugal_nav/MissionState.h>
#include <frugal_nav/ros/conversions.hpp>

// The BARN challenge's run, as its own script makes it: a client of move_base asks for odom (0, 10), and what
// counts is how the robot moves in the world. Nothing but arguments of lidar.launch is made for it.
namespace frugal_nav {
namespace {

constexpr double kAhead_m = 10.0;
constexpr double kReached_m = 1.0;
constexpr double kClockStarts_m = 0.1;
constexpr double kTimeLimit_s = 100.0;
constexpr double kWallLimit_s = 120.0;

/// How far the robot has come, by the truth.
class BarnRun {
 public:
  /// Whether every node works and waits for a goal.
  bool isReady() const { return last_ && knows_odometry_ && is_idle_; }
  bool isOver() const { return arrived_ || contacts_ > 0 || elapsed_s_ > kTimeLimit_s; }
  bool hasArrived() const { return arrived_; }
  int contacts() const { return contacts_; }
  double elapsed_s() const { return elapsed_s_; }
  double fromLine_m() const { return from_line_m_; }

 private:
  void onTruth(const nav_msgs::Odometry& msg) {
    last_ = planar(msg.pose.pose).value();
    if (!start_) start_ = last_;
    const Eigen::Vector2d p_start = start_->inverse() * last_->position();
    if (!moved_at_ && p_start.norm() > kClockStarts_m) moved_at_ = msg.header.stamp;
    if (moved_at_) elapsed_s_ = (msg.header.stamp - *moved_at_).toSec();
    from_line_m_ = std::max(from_line_m_, std::abs(p_start.y()));
    arrived_ = arrived_ || (p_start - Eigen::Vector2d(kAhead_m, 0.0)).norm() < kReached_m;
  }
  void onContact(const Contact& contact) {
    ++contacts_;
    ADD_FAILURE() << contact.link << " touched " << contact.other;
  }

  ros::NodeHandle nh_;
  std::optional<Pose2> start_, last_;
  std::optional<ros::Time> moved_at_;
  double elapsed_s_ = 0.0;
  double from_line_m_ = 0.0;
  bool arrived_ = false;
  bool knows_odometry_ = false;
  bool is_idle_ = false;
  int contacts_ = 0;
  ros::Subscriber truth_sub_ = nh_.subscribe("ground_truth/odom", 1000, &BarnRun::onTruth, this);
  ros::Subscriber contact_sub_ = nh_.subscribe("ground_truth/contact", 100, &BarnRun::onContact, this);
  ros::Subscriber state_sub_ = nh_.subscribe<MissionState>(
      "mission/state", 100,
      [this](const MissionStateConstPtr& msg) { knows_odometry_ = !msg->header.stamp.isZero(); });
  ros::Subscriber local_sub_ = nh_.subscribe<LocalCommand>(
      "avoidance/command", 100,
      [this](const LocalCommandConstPtr& msg) { is_idle_ = msg->status == LocalCommand::STATUS_IDLE; });
};

TEST(BarnClient, IsDrivenThroughAFieldOfCylinders) {
  BarnRun run;
  ASSERT_TRUE(test::waitUntil([&run] { return run.isReady(); }, 60.0)) << "a node does not work";
  actionlib::SimpleActionClient<move_base_msgs::MoveBaseAction> client("/move_base", false);
  ASSERT_TRUE(test::waitUntil([&client] { return client.isServerConnected(); }, 60.0));
  move_base_msgs::MoveBaseGoal goal;
  goal.target_pose.header.frame_id = "odom";
  goal.target_pose.pose.position.y = kAhead_m;
  goal.target_pose.pose.orientation.w = 1.0;
  client.sendGoal(goal);
  const auto is_over = [&] { return run.isOver() || client.getState().isDone(); };
  ASSERT_TRUE(test::waitUntil(is_over, kWallLimit_s)) << "no end of the run";
  EXPECT_TRUE(run.hasArrived()) << client.getState().toString() << ": " << client.getState().getText();
  EXPECT_EQ(run.contacts(), 0);
  EXPECT_GT(run.fromLine_m(), 0.5) << "the field left it nothing to avoid";
  std::printf("%.1f s, %.2f m off the straight line at most\n", run.elapsed_s(), run.fromLine_m());
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "barn_client_test");
  ros::NodeHandle nh;
  return RUN_ALL_TESTS();
}
