#include "mission_driver.hpp"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace frugal_nav {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr Pose2 kGoal{3.0, 0.0, 0.0};

/// The one event of a mission that has ended once.
MissionEvent onlyEvent(Mission& mission) {
  const std::vector<MissionEvent> events = mission.takeEvents();
  EXPECT_EQ(events.size(), 1U);
  return events.empty() ? MissionEvent{} : events.front();
}

TEST(Mission, IdlesWithoutGoal) {
  MissionDriver driver;
  const MissionOutput output = driver.run(1.0);
  EXPECT_EQ(output.status.mode, Mode::kIdle);
  EXPECT_EQ(output.status.phase, MissionPhase::kIdle);
  EXPECT_FALSE(output.command);
  EXPECT_EQ(output.status.stamp, driver.odometry.stamp);
}

TEST(Mission, DrivesInTheConfiguredMode) {
  for (const auto& [name, mode] : {std::pair{"lidar", Mode::kLidar}, std::pair{"camera", Mode::kCamera}}) {
    MissionParams params;
    params.drive_mode = name;
    MissionDriver driver(params);
    EXPECT_EQ(driver.setGoal(kGoal), 1U);
    const MissionOutput output = driver.step();
    EXPECT_EQ(output.status.mode, mode);
    EXPECT_EQ(output.status.phase, MissionPhase::kDriving);
    EXPECT_EQ(output.status.goal_number, 1U);
  }
}

TEST(Mission, ReachesTheGoalOnlyWhenStandingInIt) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.odometry.odom_from_base = {2.70, 0.0, 0.0};
  driver.odometry.twist = {0.2, 0.0};
  EXPECT_EQ(driver.step().status.mode, Mode::kLidar) << "outside the tolerance";
  driver.odometry.odom_from_base = {2.96, 0.0, 0.0};
  const MissionOutput braking = driver.step();
  EXPECT_EQ(braking.status.phase, MissionPhase::kDriving) << "still rolling";
  ASSERT_TRUE(braking.command);
  EXPECT_TRUE(braking.command->isZero());
  driver.odometry.twist = {};
  driver.run(0.1);
  const MissionEvent event = onlyEvent(driver.mission);
  EXPECT_EQ(event.phase, MissionPhase::kReached);
  EXPECT_EQ(event.reason, "goal reached");
  EXPECT_EQ(driver.mission.status().mode, Mode::kIdle);
}

TEST(Mission, TakesTheToleranceWhenItGetsNoNearer) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.odometry.odom_from_base = {2.80, 0.0, 0.0};
  driver.run(0.9);
  EXPECT_TRUE(driver.mission.active()) << "closing_s is 1 s";
  driver.run(0.3);
  EXPECT_EQ(onlyEvent(driver.mission).phase, MissionPhase::kReached);
}

TEST(Mission, DrivesUpAgainAfterSlippingPast) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.odometry.odom_from_base = {2.96, 0.0, 0.0};
  driver.odometry.twist = {0.5, 0.0};
  driver.step();
  driver.odometry.odom_from_base = {3.4, 0.0, 0.0};
  driver.odometry.twist = {};
  EXPECT_EQ(driver.step().status.mode, Mode::kLidar);
  EXPECT_TRUE(driver.mission.takeEvents().empty());
}

TEST(Mission, TurnsToTheGoalsHeading) {
  MissionDriver driver;
  driver.odometry.odom_from_base = {3.0, 0.0, 0.0};
  driver.setGoal({3.0, 0.0, -2.0});
  double turned_for_s = 0.0;
  while (driver.mission.active() && turned_for_s < 15.0) {
    const MissionOutput output = driver.stepObeying();
    turned_for_s += 0.05;
    if (output.command) {
      EXPECT_EQ(output.command->v_mps, 0.0);
      EXPECT_LE(output.command->w_radps, 0.0) << "the short way round";
    }
  }
  EXPECT_EQ(onlyEvent(driver.mission).reason, "goal reached");
  EXPECT_NEAR(driver.odometry.odom_from_base.yaw_rad, -2.0, MissionParams{}.yaw_tolerance_rad);
}

TEST(Mission, IgnoresTheHeadingWhenToldTo) {
  MissionParams params;
  params.use_goal_yaw = false;
  MissionDriver parameter(params);
  parameter.odometry.odom_from_base = {3.0, 0.0, 0.0};
  parameter.setGoal({3.0, 0.0, 3.0});
  parameter.run(0.2);
  EXPECT_EQ(onlyEvent(parameter.mission).reason, "goal reached");

  MissionDriver one_goal;
  one_goal.odometry.odom_from_base = {3.0, 0.0, 0.0};
  one_goal.setGoal({3.0, 0.0, 3.0}, false);
  one_goal.run(0.2);
  EXPECT_EQ(onlyEvent(one_goal.mission).reason, "goal reached");
}

TEST(Mission, ReachesEvenWhenTheTurnIsHeldUp) {
  MissionDriver driver;
  driver.odometry.odom_from_base = {3.0, 0.0, 0.0};
  driver.setGoal({3.0, 0.0, 3.0});
  driver.run(MissionParams{}.align_timeout_s + 1.0);
  const MissionEvent event = onlyEvent(driver.mission);
  EXPECT_EQ(event.phase, MissionPhase::kReached);
  EXPECT_THAT(event.reason, HasSubstr("turn is held up"));
}

TEST(Mission, CancelsAtOnce) {
  MissionDriver driver;
  const std::uint32_t number = driver.setGoal(kGoal);
  driver.run(1.0);
  driver.mission.cancel();
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kCancelled) << "before any further input";
  EXPECT_EQ(driver.mission.status().mode, Mode::kIdle);
  const MissionEvent event = onlyEvent(driver.mission);
  EXPECT_EQ(event.goal_number, number);
  EXPECT_EQ(event.phase, MissionPhase::kCancelled);
  EXPECT_EQ(driver.run(1.0).status.phase, MissionPhase::kCancelled) << "stays so";
}

TEST(Mission, CancelWithoutGoalChangesNothing) {
  MissionDriver driver;
  driver.mission.cancel();
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kIdle);
  EXPECT_TRUE(driver.mission.takeEvents().empty());
}

TEST(Mission, NewGoalPreemptsTheOld) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.run(1.0);
  EXPECT_EQ(driver.setGoal({0.0, 2.0, 0.0}), 2U);
  const MissionEvent event = onlyEvent(driver.mission);
  EXPECT_EQ(event.goal_number, 1U);
  EXPECT_EQ(event.reason, "preempted by a new goal");
  EXPECT_TRUE(driver.mission.active());
  EXPECT_EQ(driver.mission.goal().y_m, 2.0);
}

TEST(Mission, RefusesGoalsThatCannotBeDrivenTo) {
  MissionDriver driver;
  driver.setGoal({std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0});
  EXPECT_EQ(onlyEvent(driver.mission).reason, "goal is not finite");
  driver.mission.refuseGoal("goal in an unknown frame: moon", stampFromSeconds(101.0));
  EXPECT_EQ(onlyEvent(driver.mission).reason, "goal in an unknown frame: moon");
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kAborted);
  EXPECT_EQ(driver.step().status.mode, Mode::kIdle);
}

TEST(Mission, RefusedGoalEndsTheOneOnItsWay) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.run(0.5);
  driver.mission.refuseGoal("zero quaternion", driver.odometry.stamp);
  const std::vector<MissionEvent> events = driver.mission.takeEvents();
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].reason, "preempted by a new goal");
  EXPECT_EQ(events[1].reason, "zero quaternion");
  EXPECT_EQ(driver.step().status.mode, Mode::kIdle);
}

TEST(Mission, GivesUpWhenTheOdometryStops) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.run(1.0);
  EXPECT_FALSE(driver.mission.checkOdometry(stampFromSeconds(driver.time_s + 0.9)));
  EXPECT_TRUE(driver.mission.checkOdometry(stampFromSeconds(driver.time_s + 1.1)));
  EXPECT_THAT(onlyEvent(driver.mission).reason, StartsWith("odometry lost"));
}

TEST(Mission, GivesUpWhenNoOdometryEverComes) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  EXPECT_TRUE(driver.mission.checkOdometry(stampFromSeconds(driver.time_s + 1.1)));
  EXPECT_THAT(onlyEvent(driver.mission).reason, StartsWith("odometry lost"));
}

TEST(Mission, AGoalFromBeforeTheClockWaitsForOdometryFromTheFirstInstant) {
  MissionDriver driver;
  driver.mission.setGoal(kGoal, Stamp{}, true);
  EXPECT_FALSE(driver.mission.checkOdometry(stampFromSeconds(50.0)));
  EXPECT_FALSE(driver.mission.checkOdometry(stampFromSeconds(50.9)));
  EXPECT_TRUE(driver.mission.checkOdometry(stampFromSeconds(51.1)));
}

TEST(Mission, GivesUpWhenAvoidanceStops) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.run(1.0);
  driver.command.status = MotionCommand::Status::kStopped;
  driver.command.holds = MotionCommand::Holds::kNothing;
  driver.command.reason = "no scan for 0.6 s";
  driver.run(4.5);
  EXPECT_TRUE(driver.mission.active()) << "stopped_timeout_s is 5 s";
  driver.run(1.0);
  EXPECT_EQ(onlyEvent(driver.mission).reason, "avoidance stopped: no scan for 0.6 s");
}

TEST(Mission, GivesUpWhenAvoidanceIsGone) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.run(1.0);
  driver.feed_command = false;
  driver.runWhile(MissionPhase::kDriving, 10.0);
  EXPECT_EQ(onlyEvent(driver.mission).reason, "avoidance stopped: no command from it");
}

TEST(Mission, GivesUpWhenAvoidanceNeverHearsOfTheGoal) {
  MissionDriver driver;
  driver.command.status = MotionCommand::Status::kIdle;
  driver.command.holds = MotionCommand::Holds::kNothing;
  driver.path_found = false;
  driver.setGoal(kGoal);
  driver.runWhile(MissionPhase::kDriving, 10.0);
  EXPECT_EQ(onlyEvent(driver.mission).reason, "avoidance stopped: it has not heard of the goal");
}

TEST(Mission, GivesUpInCameraModeWhenThePlannerIsGone) {
  MissionParams params;
  params.drive_mode = "camera";
  MissionDriver driver(params);
  driver.feed_command = false;
  driver.setGoal(kGoal);
  driver.run(3.0);
  EXPECT_TRUE(driver.mission.active()) << "camera mode needs no avoidance";
  driver.feed_path = false;
  driver.runWhile(MissionPhase::kDriving, 10.0);
  EXPECT_EQ(onlyEvent(driver.mission).reason, "planner stopped: no path from it");
}

TEST(Mission, GivesUpAfterTheGoalsTime) {
  MissionParams params;
  params.goal_timeout_s = 3.0;
  MissionDriver driver(params);
  driver.setGoal(kGoal);
  driver.run(2.9);
  EXPECT_TRUE(driver.mission.active());
  driver.run(0.3);
  EXPECT_THAT(onlyEvent(driver.mission).reason, StartsWith("goal time-out"));
}

TEST(Mission, GivesUpWhenTimeJumpsBack) {
  enum class Input { kOdometry, kPath, kCommand };
  for (const Input input : {Input::kOdometry, Input::kPath, Input::kCommand}) {
    MissionDriver driver;
    driver.setGoal(kGoal);
    driver.run(1.0);
    const Stamp earlier = stampFromSeconds(5.0);
    if (input == Input::kPath) driver.mission.setPath({}, earlier);
    driver.command.stamp = driver.odometry.stamp = earlier;
    if (input == Input::kCommand) driver.mission.setLocalCommand(driver.command);
    if (input == Input::kOdometry) driver.mission.update(driver.odometry);
    EXPECT_EQ(onlyEvent(driver.mission).reason, "time jumped back");
    driver.time_s = 5.0;
    driver.setGoal(kGoal);
    EXPECT_EQ(driver.run(2.0).status.phase, MissionPhase::kDriving) << "drives in the new time";
  }
}

TEST(Mission, GivesUpOnOdometryThatIsNotFinite) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.run(0.5);
  driver.odometry.odom_from_base.x_m = std::numeric_limits<double>::infinity();
  EXPECT_EQ(driver.step().status.mode, Mode::kIdle);
  EXPECT_THAT(onlyEvent(driver.mission).reason, StartsWith("odometry lost"));
}

TEST(Mission, ManualModeCancelsAndRefusesGoals) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.run(0.5);
  driver.mission.setManual(true);
  EXPECT_EQ(onlyEvent(driver.mission).phase, MissionPhase::kCancelled);
  EXPECT_EQ(driver.step().status.mode, Mode::kManual);
  driver.setGoal(kGoal);
  EXPECT_THAT(onlyEvent(driver.mission).reason, HasSubstr("manual"));
  EXPECT_EQ(driver.step().status.mode, Mode::kManual);
  driver.mission.setManual(false);
  EXPECT_EQ(driver.step().status.mode, Mode::kIdle);
}

TEST(Mission, RefusesContradictingParameters) {
  MissionParams params;
  params.xy_aim_m = 0.5;
  EXPECT_THROW(Mission{params}, ConfigError);
}

}  // namespace
}  // namespace frugal_nav
