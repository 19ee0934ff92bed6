#include "mission_graph.hpp"

#include <limits>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <std_srvs/SetBool.h>
#include <tf2_ros/static_transform_broadcaster.h>

namespace frugal_nav {
namespace {

using actionlib::SimpleClientGoalState;
using testing::HasSubstr;
using testing::StartsWith;

class MissionNodeTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(graph_.connect());
    client_ = std::make_unique<MoveBaseClient>("move_base", false);  // blocks until there is a time
    ASSERT_TRUE(graph_.stepUntil([this] { return client_->isServerConnected(); }));
  }

  void TearDown() override {
    client_->cancelAllGoals();
    graph_.stepUntil([this] { return !driving(); });
  }

  bool driving() const {
    return graph_.states.back().state == MissionState::STATE_DRIVING ||
           graph_.states.back().state == MissionState::STATE_RECOVERING;
  }

  /// Sends a goal and steps until it is on its way.
  void startDriving(const Pose2& goal) {
    client_->sendGoal(moveBaseGoal(goal));
    ASSERT_TRUE(graph_.stepUntil([this] { return driving() && graph_.goal; }));
  }

  /// Sends a goal that must not be driven to, and returns the text it is aborted with.
  std::string refusal(const move_base_msgs::MoveBaseGoal& goal) {
    const std::size_t before = graph_.states.size();
    client_->sendGoal(goal);
    EXPECT_TRUE(graph_.stepUntil([this] { return client_->getState().isDone(); }));
    EXPECT_EQ(client_->getState().state_, SimpleClientGoalState::ABORTED);
    for (std::size_t i = before; i < graph_.states.size(); ++i)
      EXPECT_EQ(graph_.states[i].mode, MissionState::MODE_IDLE);
    EXPECT_EQ(graph_.states.back().state, MissionState::STATE_ABORTED);
    return client_->getState().getText();
  }

  MissionGraph graph_;
  std::unique_ptr<MoveBaseClient> client_;
};

TEST_F(MissionNodeTest, ServesAClientOfMoveBase) {
  int feedbacks = 0;
  graph_.odom_from_base = {};
  client_->sendGoal(moveBaseGoal({1.5, 0.5, 1.0}), {}, {},
                    [&feedbacks](const move_base_msgs::MoveBaseFeedbackConstPtr& feedback) {
                      EXPECT_EQ(feedback->base_position.header.frame_id, "odom");
                      ++feedbacks;
                    });
  ASSERT_TRUE(graph_.stepUntil([this] { return client_->getState().isDone(); }));
  EXPECT_EQ(client_->getState().state_, SimpleClientGoalState::SUCCEEDED);
  EXPECT_EQ(client_->getState().getText(), "goal reached");
  EXPECT_GT(feedbacks, 3);
  EXPECT_LE(distance(graph_.odom_from_base, {1.5, 0.5, 0.0}), 0.25);
  EXPECT_NEAR(graph_.odom_from_base.yaw_rad, 1.0, 0.2);
  EXPECT_EQ(graph_.states.back().state, MissionState::STATE_REACHED);
}

TEST_F(MissionNodeTest, AnswersEveryOdometryWithItsStamp) {
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(graph_.step());
}

TEST_F(MissionNodeTest, OdometryInAnotherFrameIsNone) {
  ros::NodeHandle nh;
  ros::Publisher publisher = nh.advertise<nav_msgs::Odometry>("odom", 10);
  Odometry odometry;
  odometry.stamp = toStamp(graph_.now() + ros::Duration(0.01));
  publisher.publish(toRos(odometry, "map", "base_link"));
  ASSERT_TRUE(graph_.step());  // one connection: once this is answered, the one before has been seen
  for (const MissionState& state : graph_.states) EXPECT_NE(toStamp(state.header.stamp), odometry.stamp);
}

TEST_F(MissionNodeTest, RefusesAGoalInAnUnknownFrame) {
  EXPECT_THAT(refusal(moveBaseGoal({1.0, 0.0, 0.0}, "moon")),
              StartsWith("goal in an unknown frame: \"moon\""));
  EXPECT_THAT(refusal(moveBaseGoal({1.0, 0.0, 0.0}, "")), StartsWith("goal in an unknown frame"));
}

TEST_F(MissionNodeTest, RefusesAZeroQuaternion) {
  move_base_msgs::MoveBaseGoal goal = moveBaseGoal({1.0, 0.0, 0.0});
  goal.target_pose.pose.orientation.w = 0.0;
  EXPECT_THAT(refusal(goal), HasSubstr("zero quaternion"));
  goal.target_pose.pose.orientation.w = 2.0;
  EXPECT_THAT(refusal(goal), HasSubstr("quaternion of length 2"));
}

TEST_F(MissionNodeTest, RefusesAGoalThatIsNotFinite) {
  move_base_msgs::MoveBaseGoal goal = moveBaseGoal({1.0, 0.0, 0.0});
  goal.target_pose.pose.position.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(goal), "goal is not finite");
}

TEST_F(MissionNodeTest, SaysCancelledWithoutWaitingForOdometry) {
  ASSERT_NO_FATAL_FAILURE(startDriving({5.0, 0.0, 0.0}));
  const std::size_t before = graph_.states.size();
  client_->cancelGoal();
  // No step: no further odometry reaches the node.
  ASSERT_TRUE(test::waitUntil([&] { return graph_.states.size() > before; }));
  EXPECT_EQ(graph_.states[before].state, MissionState::STATE_CANCELLED);
  EXPECT_EQ(graph_.states[before].mode, MissionState::MODE_IDLE);
  ASSERT_TRUE(test::waitUntil([this] { return client_->getState().isDone(); }));
  EXPECT_EQ(client_->getState().state_, SimpleClientGoalState::PREEMPTED);
}

TEST_F(MissionNodeTest, NewGoalPreemptsTheOld) {
  MoveBaseClient second("move_base", false);
  ASSERT_TRUE(graph_.stepUntil([&] { return second.isServerConnected(); }));
  ASSERT_NO_FATAL_FAILURE(startDriving({5.0, 0.0, 0.0}));
  second.sendGoal(moveBaseGoal({0.0, 5.0, 0.0}));
  ASSERT_TRUE(graph_.stepUntil([this] { return client_->getState().isDone(); }));
  EXPECT_EQ(client_->getState().state_, SimpleClientGoalState::PREEMPTED);
  EXPECT_EQ(client_->getState().getText(), "preempted by a new goal");
  EXPECT_TRUE(driving());
  ASSERT_TRUE(graph_.goal);
  EXPECT_NEAR(graph_.goal->y_m, 5.0, 1e-9);
  second.cancelAllGoals();
}

TEST_F(MissionNodeTest, StampsAGoalNoOlderThanTheStateBeforeIt) {
  // Planners forget a goal when a later state says that nothing is driven to.
  graph_.clock_lag_s = 0.04;  // below the step, so that time does not go back
  ASSERT_TRUE(graph_.step());
  ASSERT_TRUE(graph_.step());
  const ros::Time idle = graph_.states.back().header.stamp;
  client_->sendGoal(moveBaseGoal({5.0, 0.0, 0.0}));
  ASSERT_TRUE(test::waitUntil([this] { return driving(); }));
  ASSERT_TRUE(test::waitUntil([&] { return graph_.goal_stamp >= idle; })) << graph_.goal_stamp;
}

TEST_F(MissionNodeTest, TakesSimpleGoalsInAFrameOfTf) {
  tf2_ros::StaticTransformBroadcaster broadcaster;
  geometry_msgs::TransformStamped odom_from_room;
  odom_from_room.header.frame_id = "odom";
  odom_from_room.child_frame_id = "room";
  odom_from_room.transform.translation.x = 2.0;
  odom_from_room.transform.rotation.z = odom_from_room.transform.rotation.w = std::sqrt(0.5);
  broadcaster.sendTransform(odom_from_room);

  ros::NodeHandle nh;
  ros::Publisher publisher = nh.advertise<geometry_msgs::PoseStamped>("move_base_simple/goal", 1);
  ASSERT_TRUE(test::waitForSubscriber(publisher));
  geometry_msgs::PoseStamped goal = moveBaseGoal({3.0, 0.0, 0.0}, "room").target_pose;
  // The transform may still be on its way: as a user would, send the goal again.
  ASSERT_TRUE(graph_.stepUntil([&] {
    if (!driving()) publisher.publish(goal);
    return driving() && graph_.goal;
  }));
  EXPECT_NEAR(graph_.goal->x_m, 2.0, 1e-9);
  EXPECT_NEAR(graph_.goal->y_m, 3.0, 1e-9);
  EXPECT_NEAR(graph_.goal->yaw_rad, M_PI / 2.0, 1e-9);
}

TEST_F(MissionNodeTest, GivesUpWithThePlannersReason) {
  ASSERT_NO_FATAL_FAILURE(startDriving({5.0, 0.0, 0.0}));
  graph_.no_path_reason = "the goal lies in an obstacle";
  ASSERT_TRUE(graph_.stepUntil([this] { return client_->getState().isDone(); }));
  EXPECT_EQ(client_->getState().state_, SimpleClientGoalState::ABORTED);
  EXPECT_THAT(client_->getState().getText(), HasSubstr("the goal lies in an obstacle"));
}

TEST_F(MissionNodeTest, GivesUpWhenOdometryStops) {
  ASSERT_NO_FATAL_FAILURE(startDriving({5.0, 0.0, 0.0}));
  graph_.publish_odometry = false;
  ASSERT_TRUE(graph_.stepUntil([this] { return client_->getState().isDone(); }));
  EXPECT_EQ(client_->getState().state_, SimpleClientGoalState::ABORTED);
  EXPECT_THAT(client_->getState().getText(), StartsWith("odometry lost"));
  EXPECT_EQ(graph_.states.back().mode, MissionState::MODE_IDLE);
  graph_.publish_odometry = true;
}

TEST_F(MissionNodeTest, SwitchesToManualAndBack) {
  ASSERT_NO_FATAL_FAILURE(startDriving({5.0, 0.0, 0.0}));
  ros::NodeHandle nh;
  ros::ServiceClient service = nh.serviceClient<std_srvs::SetBool>("mission/set_manual");
  std_srvs::SetBool request;
  request.request.data = 1;
  ASSERT_TRUE(service.call(request));
  ASSERT_TRUE(graph_.step());
  EXPECT_EQ(graph_.states.back().mode, MissionState::MODE_MANUAL);
  ASSERT_TRUE(graph_.stepUntil([this] { return client_->getState().isDone(); }));
  EXPECT_THAT(client_->getState().getText(), HasSubstr("manual"));
  request.request.data = 0;
  ASSERT_TRUE(service.call(request));
  ASSERT_TRUE(graph_.step());
  EXPECT_EQ(graph_.states.back().mode, MissionState::MODE_IDLE);
}

TEST(MissionNodeStart, NamesAnUnknownParameter) {
  const auto result = test::runProgram("mission_node", "__name:=bad_mission _no_such_key:=1");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("no_such_key"));
  ros::param::del("bad_mission");
}

TEST(MissionNodeStart, NamesAMissingWaypointFile) {
  const auto result =
      test::runProgram("mission_node", "__name:=bad_mission _waypoints_file:=no_such_tour.yaml");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("no_such_tour.yaml: cannot be read"));
  ros::param::del("bad_mission");
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "mission_node_test");
  ros::NodeHandle nh;  // keeps ROS running between the tests
  return RUN_ALL_TESTS();
}
