#include "mission_graph.hpp"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tf2_ros/transform_broadcaster.h>

namespace frugal_nav {
namespace {

using testing::HasSubstr;

/// What a localization gives: the transform from map to odom, of the present time.
class MapGoalTest : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(graph_.connect()); }
  void localize(const Pose2& map_from_odom) {
    geometry_msgs::TransformStamped transform;
    transform.header.stamp = graph_.now();
    transform.header.frame_id = "map";
    transform.child_frame_id = "odom";
    const geometry_msgs::Pose pose = toRos(map_from_odom);
    transform.transform.translation.x = pose.position.x;
    transform.transform.translation.y = pose.position.y;
    transform.transform.rotation = pose.orientation;
    broadcaster_.sendTransform(transform);
  }
  const MissionState& state() const { return graph_.states.back(); }
  bool goalIsNear(const Pose2& place) const { return graph_.goal && distance(*graph_.goal, place) < 0.01; }

  MissionGraph graph_;
  tf2_ros::TransformBroadcaster broadcaster_;
};

// The tour of the .test file, whose one waypoint lies at (4, 0) of the map.
TEST_F(MapGoalTest, WaitsForTheFirstFixThenFollowsTheMap) {
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(graph_.step());
    ASSERT_EQ(state().goal_number, 0U) << "a goal without a map";
  }
  Pose2 map_from_odom{1.0, 0.0, 0.0};
  ASSERT_TRUE(graph_.stepUntil([&] {
    localize(map_from_odom);
    return goalIsNear({3.0, 0.0, 0.0}) &&
           state().goal_number == 1U;  // topics of their own: either comes first
  }));
  map_from_odom = {1.2, 0.1, 0.0};  // the robot learns better where it is
  ASSERT_TRUE(graph_.stepUntil([&] {
    localize(map_from_odom);
    return goalIsNear({2.8, -0.1, 0.0});
  }));
  EXPECT_EQ(state().goal_number, 1U);

  // The localization falls silent: the robot stands, and says why.
  ASSERT_TRUE(graph_.stepUntil([&] { return state().mode == MissionState::MODE_ALIGNING; }));
  EXPECT_THAT(state().reason, HasSubstr("\"map\" is stale"));
  const Pose2 stood = graph_.odom_from_base;
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(graph_.step());
  EXPECT_LT(distance(graph_.odom_from_base, stood), 1e-9);

  ASSERT_TRUE(graph_.stepUntil([&] {
    localize(map_from_odom);
    return state().state == MissionState::STATE_REACHED;
  }));
  EXPECT_LT(distance(graph_.odom_from_base, {2.8, -0.1, 0.0}), 0.3);
}

TEST_F(MapGoalTest, AGoalOfAMapThatIsStaleIsRefused) {
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(graph_.step());
  MoveBaseClient client("move_base", false);
  ASSERT_TRUE(test::waitUntil([&] { return client.isServerConnected(); }));
  client.sendGoal(moveBaseGoal({1.0, 0.0, 0.0}, "map"));
  ASSERT_TRUE(graph_.stepUntil([&] { return client.getState().isDone(); }));
  EXPECT_EQ(client.getState().state_, actionlib::SimpleClientGoalState::ABORTED);
  EXPECT_THAT(client.getState().getText(), HasSubstr("stale"));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "mission_map_goal_test");
  ros::NodeHandle nh;
  return RUN_ALL_TESTS();
}
