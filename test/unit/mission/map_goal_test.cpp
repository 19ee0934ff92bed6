// Goals of a map, whose place in odom moves while the robot drives.

#include "mission_driver.hpp"

#include <gtest/gtest.h>

namespace frugal_nav {
namespace {

constexpr Pose2 kGoal{3.0, 0.0, 0.0};

TEST(MapGoal, MovesUnderItsNumber) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.run(1.0);
  const std::uint32_t changes = driver.mission.goalChanges();
  driver.mission.moveGoal({3.5, 0.1, 0.0});
  const MissionOutput output = driver.step();
  EXPECT_EQ(output.status.goal_number, 1U);
  EXPECT_EQ(output.status.phase, MissionPhase::kDriving);
  EXPECT_EQ(driver.mission.goalChanges(), changes + 1);
  EXPECT_DOUBLE_EQ(driver.mission.goal().x_m, 3.5);
  // The robot is at the goal where it is now, not where it was.
  driver.odometry.odom_from_base = kGoal;
  EXPECT_EQ(driver.run(2.0).status.mode, Mode::kLidar);
  driver.odometry.odom_from_base = {3.5, 0.1, 0.0};
  driver.runWhile(MissionPhase::kDriving, 3.0);
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kReached);
}

TEST(MapGoal, StaysForLessThanALocalizationIsGoodTo) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  const std::uint32_t changes = driver.mission.goalChanges();
  for (int i = 0; i < 10; ++i) driver.mission.moveGoal({3.0 + 0.01 * (i % 3), 0.02, 0.01});
  EXPECT_EQ(driver.mission.goalChanges(), changes);
  driver.mission.moveGoal({3.0, 0.0, 0.1});
  EXPECT_EQ(driver.mission.goalChanges(), changes + 1) << "its heading counts too";
}

TEST(MapGoal, WithoutAKnownPlaceTheRobotStandsUntilThereIsOne) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.run(1.0);
  driver.mission.holdGoal("the map is gone");
  const MissionOutput held = driver.step();
  EXPECT_EQ(held.status.mode, Mode::kAligning);
  EXPECT_EQ(held.status.reason, "the map is gone");
  ASSERT_TRUE(held.command);
  EXPECT_TRUE(held.command->isZero());
  driver.mission.moveGoal(kGoal);
  EXPECT_EQ(driver.step().status.mode, Mode::kLidar);
}

TEST(MapGoal, GivesUpWhenNobodyTellsItsPlace) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.run(1.0);
  driver.mission.holdGoal("the map is gone");
  driver.run(4.8);
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kDriving) << "stopped_timeout_s is 5 s";
  driver.run(0.4);
  const std::vector<MissionEvent> events = driver.mission.takeEvents();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].phase, MissionPhase::kAborted);
  EXPECT_EQ(events[0].reason, "the map is gone");
  // The next goal is not held.
  driver.setGoal(kGoal);
  EXPECT_EQ(driver.step().status.mode, Mode::kLidar);
}

TEST(MapGoal, NothingMovesWithoutAGoal) {
  MissionDriver driver;
  driver.mission.moveGoal(kGoal);
  driver.mission.holdGoal("the map is gone");
  EXPECT_EQ(driver.step().status.mode, Mode::kIdle);
  EXPECT_EQ(driver.mission.goalChanges(), 0U);
}

}  // namespace
}  // namespace frugal_nav
