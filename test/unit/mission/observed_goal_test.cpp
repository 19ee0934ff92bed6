#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unit/mission/mission_driver.hpp>

namespace frugal_nav {
namespace {

using ::testing::HasSubstr;
using Vec = Eigen::Vector2d;

/// A robot at the origin that gets paths, no avoidance commands, and sees a person.
class FollowTest : public ::testing::Test {
 protected:
  explicit FollowTest(const MissionParams& params = cameraParams()) : driver_(params) {
    driver_.feed_command = false;
    driver_.step();
  }

  void see(const Vec& person) { driver_.mission.setObservedGoal(person, stampFromSeconds(driver_.time_s)); }
  /// Drives on for a while; the person is seen at each instant, or never.
  MissionOutput run(double duration_s, const std::optional<Vec>& person) {
    MissionOutput output;
    for (double end_s = driver_.time_s + duration_s; driver_.time_s < end_s - 1e-9;) {
      if (person) see(*person);
      output = driver_.step();
      if (creeps_ && output.status.mode == Mode::kCamera) driver_.odometry.odom_from_base.x_m += 0.005;
    }
    return output;
  }
  void place(double x, double y, double yaw) { driver_.odometry.odom_from_base = {x, y, yaw}; }

  MissionDriver driver_;
  bool creeps_ = false;  ///< run() drives at 0.1 m/s
};

TEST_F(FollowTest, TakesTheFirstPersonForItsGoal) {
  EXPECT_EQ(driver_.mission.status().mode, Mode::kIdle);
  see({3.0, 4.0});
  const MissionOutput output = driver_.step();
  EXPECT_EQ(output.status.mode, Mode::kCamera);
  EXPECT_EQ(output.status.phase, MissionPhase::kDriving);
  EXPECT_EQ(output.status.goal_number, 1U);
  // 0.8 m before the person on the line from the origin, which is 5 m long.
  const Pose2 goal = driver_.mission.goal();
  EXPECT_NEAR(goal.x_m, 3.0 * 4.2 / 5.0, 1e-12);
  EXPECT_NEAR(goal.y_m, 4.0 * 4.2 / 5.0, 1e-12);
  EXPECT_NEAR(goal.yaw_rad, std::atan2(4.0, 3.0), 1e-12);
  EXPECT_EQ(driver_.mission.person().value(), Vec(3.0, 4.0));
}

TEST_F(FollowTest, MovesTheGoalWithThePersonUnderTheSameNumber) {
  see({4.0, 0.0});
  driver_.step();
  const std::uint32_t changes = driver_.mission.goalChanges();
  see({4.05, 0.05});  // 0.07 m: within the noise
  EXPECT_EQ(driver_.mission.goalChanges(), changes);
  see({4.2, 0.0});
  EXPECT_EQ(driver_.mission.goalChanges(), changes + 1);
  EXPECT_NEAR(driver_.mission.goal().x_m, 3.4, 1e-12);
  EXPECT_EQ(driver_.step().status.goal_number, 1U);
  EXPECT_EQ(driver_.mission.status().mode, Mode::kCamera);
}

TEST_F(FollowTest, KeepsItsApproachAroundAnObstacleButNotWhenThePersonLeaves) {
  see({4.0, 0.0});
  place(2.0, 1.0, 0.0);  // beside the straight line
  driver_.step();
  see({4.2, 0.0});
  EXPECT_NEAR(driver_.mission.goal().y_m, 0.0, 1e-12);
  place(2.0, 0.0, 0.0);
  driver_.step();
  see({2.0, 4.0});  // far from where it was: on the line from here
  EXPECT_NEAR(driver_.mission.goal().x_m, 2.0, 1e-12);
  EXPECT_NEAR(driver_.mission.goal().y_m, 3.2, 1e-12);
}

TEST_F(FollowTest, NeverDrivesBackwardToAPersonWhoIsNear) {
  see({0.5, 0.0});
  EXPECT_NEAR(driver_.mission.goal().x_m, 0.0, 1e-12);
}

TEST_F(FollowTest, FacesThePersonAtTheEnd) {
  see({4.0, 0.0});
  driver_.step();
  place(3.2, 0.0, 0.9);
  MissionOutput output = driver_.run(1.0);
  EXPECT_EQ(output.status.mode, Mode::kAligning);
  ASSERT_TRUE(output.command.has_value());
  EXPECT_LT(output.command->w_radps, 0.0);
  while (output.status.phase == MissionPhase::kDriving && driver_.time_s < 130.0)
    output = driver_.stepObeying();
  EXPECT_EQ(output.status.phase, MissionPhase::kReached);
  EXPECT_NEAR(driver_.odometry.odom_from_base.yaw_rad, 0.0, 0.2);
}

TEST_F(FollowTest, ComesBackToAReachedPersonOnlyWhenItHasMoved) {
  see({4.0, 0.0});
  driver_.step();
  place(3.2, 0.0, 0.0);
  run(3.0, Vec(4.0, 0.0));
  EXPECT_EQ(driver_.mission.status().phase, MissionPhase::kReached);
  run(1.0, Vec(4.5, 0.0));
  EXPECT_EQ(driver_.mission.status().goal_number, 1U);
  run(1.0, Vec(5.5, 0.0));
  EXPECT_EQ(driver_.mission.status().goal_number, 2U);
  EXPECT_EQ(driver_.mission.status().phase, MissionPhase::kDriving);
}

TEST_F(FollowTest, StandsWhenThePersonIsGoneAndGoesOnWhenItIsBack) {
  creeps_ = true;
  see({5.0, 0.0});
  MissionOutput output = run(7.9, std::nullopt);
  EXPECT_EQ(output.status.mode, Mode::kCamera);
  output = run(0.3, std::nullopt);
  EXPECT_EQ(output.status.mode, Mode::kAligning);  // the mission itself moves the base: not at all
  ASSERT_TRUE(output.command.has_value());
  EXPECT_TRUE(output.command->isZero());
  EXPECT_THAT(output.status.reason, HasSubstr("goal lost"));
  output = run(10.0, std::nullopt);
  EXPECT_EQ(output.status.phase, MissionPhase::kDriving);
  output = run(0.1, Vec(5.0, 0.0));
  EXPECT_EQ(output.status.mode, Mode::kCamera);
  EXPECT_EQ(output.status.goal_number, 1U);
}

TEST_F(FollowTest, GivesUpAPersonWhoStaysAwayAndFollowsOneWhoComes) {
  creeps_ = true;
  see({5.0, 0.0});
  MissionOutput output = run(8.2 + 30.0, std::nullopt);
  EXPECT_EQ(output.status.phase, MissionPhase::kAborted);
  EXPECT_THAT(output.status.reason, HasSubstr("goal lost"));
  output = run(0.1, Vec(5.0, 0.1));
  EXPECT_EQ(output.status.phase, MissionPhase::kDriving);
  EXPECT_EQ(output.status.goal_number, 2U);
}

TEST_F(FollowTest, MissesNobodyWhoCannotBeInView) {
  see({5.0, 0.0});
  for (int i = 0; i < 20; ++i) {
    place(0.08 * i, 0.0, 1.0);  // turned away; getting on, so as not to be stuck
    ASSERT_EQ(run(1.0, std::nullopt).status.mode, Mode::kCamera) << i;
  }
  place(3.0, 0.0, 0.0);  // so near that the head is above the image; it gets nearer, so as not to be stuck
  for (int i = 0; i < 20; ++i) {
    place(3.0 + 0.04 * i, 0.0, 0.0);
    ASSERT_EQ(run(1.0, std::nullopt).status.mode, Mode::kCamera) << i;
  }
}

TEST_F(FollowTest, MissesNobodyBehindAnObstacle) {
  see({5.0, 0.0});
  driver_.path_bend_m = 0.5;
  for (int i = 0; i < 20; ++i) {
    place(0.1 * i, 0.0, 0.0);
    ASSERT_EQ(run(1.0, std::nullopt).status.mode, Mode::kCamera) << i;
  }
}

TEST_F(FollowTest, OtherGoalsComeFirst) {
  driver_.setGoal({2.0, 0.0, 0.0});
  see({5.0, 0.0});
  EXPECT_FALSE(driver_.mission.person().has_value());
  EXPECT_EQ(driver_.mission.goal().x_m, 2.0);
  driver_.mission.cancel();
  see({5.0, 0.0});
  EXPECT_FALSE(driver_.mission.active());  // whoever cancelled does not want it to move
  driver_.mission.resumeFollowing();
  see({5.0, 0.0});
  EXPECT_TRUE(driver_.mission.active());
  EXPECT_EQ(driver_.setGoal({2.0, 0.0, 0.0}), 3U);
  EXPECT_FALSE(driver_.mission.person().has_value());
}

TEST_F(FollowTest, StaysWhereItIsInManualModeAndOnNonsense) {
  see({std::nan(""), 0.0});
  EXPECT_FALSE(driver_.mission.active());
  driver_.mission.setManual(true);
  driver_.mission.resumeFollowing();
  see({5.0, 0.0});
  EXPECT_FALSE(driver_.mission.active());
}

TEST_F(FollowTest, RecoversByTurningOnly) {
  see({5.0, 0.0});
  driver_.path_found = false;
  MissionOutput output = run(5.2, Vec(5.0, 0.0));
  EXPECT_EQ(output.status.phase, MissionPhase::kRecovering);
  bool turned = false;
  for (int i = 0; i < 200 && output.status.phase == MissionPhase::kRecovering; ++i) {
    see({5.0, 0.0});
    output = driver_.stepObeying();
    if (!output.command) continue;
    EXPECT_EQ(output.command->v_mps, 0.0);  // what lies behind is out of view
    turned = turned || output.command->w_radps != 0.0;
  }
  EXPECT_TRUE(turned);
  EXPECT_EQ(output.status.phase, MissionPhase::kDriving);
  EXPECT_NEAR(driver_.odometry.odom_from_base.yaw_rad, 0.9, 0.2);
}

TEST_F(FollowTest, RecoversByLookingAtTheGoalFirst) {
  see({5.0, 0.0});
  run(0.1, Vec(5.0, 0.0));
  driver_.path_found = false;
  driver_.odometry.odom_from_base.yaw_rad = 2.0;
  MissionOutput output = run(5.2, Vec(5.0, 0.0));
  ASSERT_EQ(output.status.phase, MissionPhase::kRecovering);
  for (int i = 0; i < 200 && output.status.phase == MissionPhase::kRecovering; ++i) {
    see({5.0, 0.0});
    output = driver_.stepObeying();
  }
  EXPECT_NEAR(driver_.odometry.odom_from_base.yaw_rad, 0.0, 0.2);
}

TEST_F(FollowTest, HaltsOnAHit) {
  see({5.0, 0.0});
  MissionOutput output;
  for (int i = 0; i < 90; ++i) {  // 4.5 s at 20 Hz
    driver_.mission.setBaseCommand({0.2, 0.0}, stampFromSeconds(driver_.time_s));
    output = run(0.05, Vec(5.0, 0.0));
  }
  EXPECT_EQ(output.status.phase, MissionPhase::kAborted);
  EXPECT_THAT(output.status.reason, HasSubstr("hit"));
}

TEST_F(FollowTest, TakesNoCollisionStopForAHit) {
  see({5.0, 0.0});
  MissionOutput output;
  for (int i = 0; i < 110; ++i) {
    driver_.mission.setBaseCommand({}, stampFromSeconds(driver_.time_s));
    output = run(0.05, Vec(5.0, 0.0));
  }
  EXPECT_EQ(output.status.phase, MissionPhase::kDriving);
}

TEST_F(FollowTest, TakesNoCreepBeforeAnObstacleForAHit) {
  see({5.0, 0.0});
  MissionOutput output;
  for (int i = 0; i < 110; ++i) {  // 5 mm/s: 2 cm in 4 s are no displacement
    driver_.mission.setBaseCommand({0.005, 0.0}, stampFromSeconds(driver_.time_s));
    output = run(0.05, Vec(5.0, 0.0));
  }
  EXPECT_EQ(output.status.phase, MissionPhase::kDriving);
}

MissionParams alignFirst() {
  MissionParams params = cameraParams();
  params.align_first = true;
  return params;
}

class AlignFirstTest : public FollowTest {
 protected:
  AlignFirstTest() : FollowTest(alignFirst()) {}
};

TEST_F(AlignFirstTest, FacesThePersonBeforeItDrives) {
  see({4.0, 2.0});
  MissionOutput output = driver_.stepObeying();
  EXPECT_EQ(output.status.mode, Mode::kAligning);
  EXPECT_GT(output.command.value().w_radps, 0.0);
  EXPECT_EQ(output.command->v_mps, 0.0);
  while (output.status.mode == Mode::kAligning && driver_.time_s < 115.0) {
    see({4.0, 2.0});
    output = driver_.stepObeying();
  }
  EXPECT_EQ(output.status.mode, Mode::kCamera);
  // 3 % of the width, E = f tan(bearing), f = 0.5 / tan(31 degrees) of it: 0.036 rad; and one step of it.
  EXPECT_NEAR(driver_.odometry.odom_from_base.yaw_rad, std::atan2(2.0, 4.0), 0.036 + 0.05 * 0.2);
}

TEST_F(AlignFirstTest, DoesNotTurnBlind) {
  see({4.0, 2.0});
  EXPECT_GT(driver_.stepObeying().command.value().w_radps, 0.0);
  driver_.feed_path = false;
  MissionOutput output;
  for (int i = 0; i < 30; ++i) output = driver_.stepObeying();  // 1.5 s, longer than input_timeout_s
  EXPECT_EQ(output.status.mode, Mode::kAligning);
  EXPECT_EQ(output.command.value().w_radps, 0.0);
}

TEST(Follow, IsOffByDefault) {
  MissionDriver driver;
  driver.step();
  driver.mission.setObservedGoal({3.0, 0.0}, stampFromSeconds(driver.time_s));
  EXPECT_FALSE(driver.mission.active());
  MissionParams params;
  params.follow_observed = true;
  driver.mission.setParams(params);
  driver.mission.setObservedGoal({3.0, 0.0}, stampFromSeconds(driver.time_s));
  EXPECT_TRUE(driver.mission.active());
}

}  // namespace
}  // namespace frugal_nav
