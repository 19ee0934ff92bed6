#include "mission_graph.hpp"

#include <memory>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>
#include <support/ros_test.hpp>

namespace frugal_nav {
namespace {

/// One node lives through all of it: the tests stand in the order of a day.
class MissionFollowTest : public testing::Test {
 protected:
  void SetUp() override {
    observed_pub_ = nh_.advertise<geometry_msgs::PoseWithCovarianceStamped>("goal/observed", 10);
    ASSERT_TRUE(graph_.connect());
    ASSERT_TRUE(test::waitForSubscriber(observed_pub_));
  }

  void see(double x, double y, const std::string& frame = "odom") {
    geometry_msgs::PoseWithCovarianceStamped msg;
    msg.header.stamp = graph_.now();
    msg.header.frame_id = frame;
    msg.pose.pose.position.x = x;
    msg.pose.pose.position.y = y;
    msg.pose.pose.position.z = 1.6;  // a head
    msg.pose.pose.orientation.w = 1.0;
    observed_pub_.publish(msg);
  }
  bool isDriving() const { return graph_.states.back().state == MissionState::STATE_DRIVING; }

  ros::NodeHandle nh_;
  ros::Publisher observed_pub_;
  MissionGraph graph_;
};

TEST_F(MissionFollowTest, IgnoresAPersonInAnUnknownFrame) {
  for (int i = 0; i < 10; ++i) {
    see(3.0, 0.0, "nowhere");
    ASSERT_TRUE(graph_.step());
    EXPECT_FALSE(isDriving());
  }
}

TEST_F(MissionFollowTest, FollowsAPersonAndStopsBeforeIt) {
  ASSERT_TRUE(graph_.stepUntil([this] {
    see(4.0, 0.0);
    return graph_.goal.has_value() && isDriving();
  }));
  const std::uint32_t number = graph_.states.back().goal_number;
  EXPECT_EQ(graph_.states.back().mode, MissionState::MODE_CAMERA);
  EXPECT_NEAR(graph_.goal->y_m, 0.0, 1e-9);
  EXPECT_NEAR(graph_.goal->x_m, 3.2, 1e-9);
  const std::size_t goals = graph_.goals;
  ASSERT_TRUE(graph_.stepUntil([&] {
    see(4.3, 0.0);
    return graph_.goals > goals;
  }));
  EXPECT_NEAR(graph_.goal->x_m, 3.5, 1e-9);
  EXPECT_EQ(graph_.states.back().goal_number, number);
  ASSERT_TRUE(graph_.stepUntil([this] { return !isDriving(); }));
  EXPECT_EQ(graph_.states.back().state, MissionState::STATE_REACHED);
  EXPECT_NEAR(graph_.odom_from_base.x_m, 3.5, 0.25);
}

TEST_F(MissionFollowTest, CancelsWhatItFollowsThoughNoClientAskedForIt) {
  ros::Publisher cancel_pub = nh_.advertise<actionlib_msgs::GoalID>("move_base/cancel", 1);
  ASSERT_TRUE(test::waitForSubscriber(cancel_pub));
  ASSERT_TRUE(graph_.stepUntil([this] {
    see(9.0, 4.0);
    return isDriving();
  }));
  cancel_pub.publish(actionlib_msgs::GoalID());
  ASSERT_TRUE(graph_.stepUntil([this] {
    see(9.0, 4.0);
    return graph_.states.back().state == MissionState::STATE_CANCELLED;
  }));
  for (int i = 0; i < 10; ++i) {  // nor does it start again by itself
    see(9.0, 4.0);
    ASSERT_TRUE(graph_.step());
    EXPECT_FALSE(isDriving());
  }
}

TEST_F(MissionFollowTest, TakesGoalsOfMoveBaseToo) {
  MoveBaseClient client("move_base", false);
  ASSERT_TRUE(graph_.stepUntil([&] { return client.isServerConnected(); }));
  client.sendGoal(moveBaseGoal({1.0, 0.0, 0.0}));
  ASSERT_TRUE(graph_.stepUntil([this] { return isDriving() && graph_.goal; }));
  EXPECT_EQ(graph_.states.back().mode, MissionState::MODE_CAMERA);
  EXPECT_NEAR(graph_.goal->x_m, 1.0, 1e-9);
  see(8.0, 0.0);
  ASSERT_TRUE(graph_.stepUntil([&] { return client.getState().isDone(); }));
  EXPECT_EQ(client.getState().state_, actionlib::SimpleClientGoalState::SUCCEEDED);
  EXPECT_NEAR(graph_.goal->x_m, 1.0, 1e-9);
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "mission_follow_test");
  ros::NodeHandle nh;  // keeps ROS running between the tests
  return RUN_ALL_TESTS();
}
