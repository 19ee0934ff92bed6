#include "mission_graph.hpp"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace frugal_nav {
namespace {

TEST(MissionTour, DrivesTheWaypointsInOrder) {
  MissionGraph graph;
  ASSERT_TRUE(graph.connect());
  Pose2 place;
  std::vector<double> goal_x_m;
  std::uint32_t last_number = 0;
  const std::size_t goals_before = graph.goals;
  ASSERT_TRUE(graph.stepUntil(
      [&] {
        const MissionState& state = graph.states.back();
        if (state.goal_number != last_number) {
          EXPECT_LE(distance(graph.odom_from_base, place), 0.25) << "the place before";
          last_number = state.goal_number;
          // The goal comes on another connection than the state that counts it.
          if (!test::waitUntil([&] { return graph.goals >= goals_before + last_number; })) return false;
          place = *graph.goal;
          goal_x_m.push_back(place.x_m);
        }
        return last_number == 3 && state.state == MissionState::STATE_REACHED;
      },
      100.0));
  EXPECT_THAT(goal_x_m, testing::ElementsAre(1.0, 1.0, 0.0));
  EXPECT_NEAR(graph.odom_from_base.yaw_rad, 0.0, 0.2) << "the last waypoint has a heading";
  // No loop: nothing follows.
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(graph.step());
    EXPECT_EQ(graph.states.back().goal_number, 3U);
  }
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "mission_tour_test");
  ros::NodeHandle nh;
  return RUN_ALL_TESTS();
}
