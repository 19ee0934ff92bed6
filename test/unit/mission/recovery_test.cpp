#include "mission_driver.hpp"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace frugal_nav {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr Pose2 kGoal{3.0, 0.0, 0.0};

TEST(Recovery, TurnsToTheClearSideThenBacksOff) {
  const RecoveryParams params;
  Recovery recovery(params);
  EXPECT_TRUE(recovery.done());
  Odometry odometry;
  recovery.start(odometry, 1.2);
  Pose2 turned;
  for (double time_s = 0.0; !recovery.done() && time_s < 30.0; time_s += 0.05) {
    odometry.stamp = stampFromSeconds(time_s);
    const Twist2 twist = recovery.update(odometry);
    EXPECT_TRUE(twist.v_mps == 0.0 || twist.w_radps == 0.0) << "one thing at a time";
    EXPECT_LE(twist.v_mps, 0.0) << "never forward";
    if (twist.w_radps != 0.0) turned = odometry.odom_from_base;
    odometry.odom_from_base = odometry.odom_from_base * arcMotion(twist, 0.05);
  }
  EXPECT_TRUE(recovery.done());
  // One step of 0.05 s past the tolerance or the distance at most.
  EXPECT_NEAR(odometry.odom_from_base.yaw_rad, 1.2, params.turn_tolerance_rad);
  EXPECT_NEAR(distance(turned, odometry.odom_from_base), params.back_off_m,
              0.05 * params.back_off_mps + 1e-9);
}

TEST(Recovery, EndsStepsThatAreHeldUp) {
  const RecoveryParams params;
  Recovery recovery(params);
  Odometry odometry;
  recovery.start(odometry, 2.0);
  double time_s = 0.0;
  for (; !recovery.done() && time_s < 60.0; time_s += 0.05) {
    odometry.stamp = stampFromSeconds(time_s);
    recovery.update(odometry);
  }
  EXPECT_NEAR(time_s, params.turn_timeout_s + params.back_off_timeout_s, 0.15);
  EXPECT_TRUE(recovery.update(odometry).isZero());
}

TEST(MissionRecovery, RecoversWhenStuckThenGivesUp) {
  MissionDriver driver;
  driver.command.holds = MotionCommand::Holds::kNothing;  // not told to move: no progress, no stall
  driver.command.status = MotionCommand::Status::kTurning;
  driver.command.clear_bearing_rad = 0.8;
  driver.setGoal(kGoal);
  int recoveries = 0;
  MissionPhase last = MissionPhase::kDriving;
  while (driver.mission.active() && driver.time_s < 300.0) {
    const MissionOutput output = driver.step();
    if (output.status.phase == MissionPhase::kRecovering && last != output.status.phase) ++recoveries;
    if (output.status.phase == MissionPhase::kRecovering) {
      EXPECT_EQ(output.status.mode, Mode::kRecovering);
      EXPECT_TRUE(output.command);
    }
    last = output.status.phase;
  }
  EXPECT_EQ(recoveries, 4);
  const std::vector<MissionEvent> events = driver.mission.takeEvents();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].phase, MissionPhase::kAborted);
  EXPECT_THAT(events[0].reason,
              AllOf(StartsWith("stuck: no progress for 8"), HasSubstr("after 4 recoveries")));
}

TEST(MissionRecovery, TurnsTowardTheClearSide) {
  for (const double bearing_rad : {1.0, -1.0}) {
    MissionDriver driver;
    driver.command.holds = MotionCommand::Holds::kNothing;
    driver.command.status = MotionCommand::Status::kTurning;
    driver.command.clear_bearing_rad = bearing_rad;
    driver.setGoal(kGoal);
    driver.runWhile(MissionPhase::kDriving, 20.0);
    const MissionOutput output = driver.step();
    ASSERT_TRUE(output.command);
    EXPECT_GT(output.command->w_radps * bearing_rad, 0.0);
  }
}

TEST(MissionRecovery, NoticesAStallBeforeTheLackOfProgress) {
  MissionDriver driver;
  driver.setGoal(kGoal);
  driver.run(3.9);
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kDriving);
  driver.run(0.3);
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kRecovering);
  EXPECT_THAT(driver.mission.status().reason, HasSubstr("standing for 4"));
}

TEST(MissionRecovery, LettingSomethingPassIsNotStuck) {
  MissionDriver driver;
  driver.command.holds = MotionCommand::Holds::kNothing;
  driver.command.status = MotionCommand::Status::kDriving;
  driver.setGoal(kGoal);
  driver.run(30.0);
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kDriving);
  driver.command.status = MotionCommand::Status::kTurning;  // and yet it stands: stuck_s is 8 s
  driver.run(7.5);
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kDriving);
  driver.run(1.0);
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kRecovering);
}

TEST(MissionRecovery, WaitsForWhatMayGoAway) {
  MissionDriver driver;
  driver.command.holds = MotionCommand::Holds::kNothing;
  driver.command.status = MotionCommand::Status::kBlocked;
  driver.setGoal(kGoal);
  driver.run(4.8);
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kDriving) << "patience_s is 5 s";
  driver.command.status = MotionCommand::Status::kDriving;
  driver.run(1.0);
  driver.command.status = MotionCommand::Status::kBlocked;
  driver.odometry.odom_from_base.x_m += 0.5;
  driver.run(4.8);
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kDriving) << "waits anew after a free moment";
  driver.run(0.5);
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kRecovering);
}

TEST(MissionRecovery, SaysThatThereIsNoPath) {
  MissionDriver driver;
  driver.command.holds = MotionCommand::Holds::kNothing;
  driver.command.status = MotionCommand::Status::kTurning;
  driver.path_found = false;
  driver.path_reason = "the goal lies in an obstacle";
  driver.setGoal(kGoal);
  while (driver.mission.active() && driver.time_s < 300.0) driver.step();
  const std::vector<MissionEvent> events = driver.mission.takeEvents();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].reason, "no path to the goal: the goal lies in an obstacle after 4 recoveries");
}

TEST(MissionRecovery, NeedsNoPathWhenToldSo) {
  MissionParams params;
  params.needs_path = false;
  MissionDriver driver(params);
  driver.path_found = false;
  driver.setGoal({6.0, 0.0, 0.0});
  for (int i = 0; i < 400; ++i) {
    driver.odometry.odom_from_base.x_m += 0.01;
    driver.step();
  }
  EXPECT_EQ(driver.mission.status().phase, MissionPhase::kDriving);
  EXPECT_EQ(driver.mission.recoveries(), 0);
}

TEST(MissionRecovery, StandsWithoutAScanWhileRecovering) {
  MissionDriver driver;
  driver.command.holds = MotionCommand::Holds::kNothing;
  driver.command.status = MotionCommand::Status::kTurning;
  driver.command.clear_bearing_rad = 1.5;
  driver.setGoal(kGoal);
  driver.runWhile(MissionPhase::kDriving, 20.0);
  ASSERT_FALSE(driver.step().command.value_or(Twist2{}).isZero());
  driver.command.status = MotionCommand::Status::kStopped;
  driver.command.reason = "no scan for 0.6 s";
  EXPECT_TRUE(driver.step().command.value_or(Twist2{}).isZero());
  driver.run(5.1);
  const std::vector<MissionEvent> events = driver.mission.takeEvents();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].reason, "avoidance stopped: no scan for 0.6 s");
}

TEST(MissionRecovery, ForgetsRecoveriesAfterProgress) {
  MissionDriver driver;
  driver.command.holds = MotionCommand::Holds::kNothing;
  driver.command.status = MotionCommand::Status::kTurning;
  driver.setGoal({8.0, 0.0, 0.0});
  driver.runWhile(MissionPhase::kDriving, 20.0);
  driver.runWhile(MissionPhase::kRecovering, 30.0);
  EXPECT_EQ(driver.mission.recoveries(), 1);
  for (int i = 0; i < 120; ++i) {
    driver.odometry.odom_from_base.x_m += 0.01;
    driver.step();
  }
  EXPECT_EQ(driver.mission.recoveries(), 0);
}

ProgressMonitor::Sample sampleAt(double time_s, double remaining_m) {
  return {stampFromSeconds(time_s), Pose2{}, remaining_m, false};
}

TEST(ProgressMonitor, CountsOnlyRealProgress) {
  ProgressMonitor monitor{ProgressParams{}};
  monitor.start(stampFromSeconds(0.0));
  for (int i = 0; i < 80; ++i) {  // jitter below step_m
    EXPECT_EQ(monitor.update(sampleAt(0.1 * i, 5.0 - 0.05 * (i % 2))), ProgressMonitor::Verdict::kMoving);
  }
  EXPECT_EQ(monitor.update(sampleAt(8.0, 5.0)), ProgressMonitor::Verdict::kNoProgress);
  EXPECT_EQ(monitor.update(sampleAt(8.1, 4.8)), ProgressMonitor::Verdict::kMoving);
  EXPECT_DOUBLE_EQ(monitor.withoutProgress_s(stampFromSeconds(9.1)), 1.0);
}

TEST(ProgressMonitor, GrantsDetoursButNotForEver) {
  ProgressParams params;
  params.max_reroutes = 3;
  ProgressMonitor monitor(params);
  monitor.start(stampFromSeconds(0.0));
  // A planner that swings between a 3 m and a 6 m way every 2 s: each swing back up is a detour.
  double stuck_at_s = 0.0;
  for (double time_s = 0.0; time_s < 60.0 && stuck_at_s == 0.0; time_s += 0.5) {
    const double remaining_m = std::fmod(time_s, 4.0) < 2.0 ? 3.0 : 6.0;
    if (monitor.update(sampleAt(time_s, remaining_m)) == ProgressMonitor::Verdict::kNoProgress)
      stuck_at_s = time_s;
  }
  // Detours at 2, 6 and 10 s, the last shrink at 12 s, stuck 8 s later.
  EXPECT_DOUBLE_EQ(stuck_at_s, 20.0);
}

TEST(ProgressMonitor, StallNeedsACommand) {
  ProgressMonitor monitor{ProgressParams{}};
  monitor.start(stampFromSeconds(0.0));
  ProgressMonitor::Sample sample = sampleAt(0.0, 5.0);
  sample.commanded = true;
  EXPECT_EQ(monitor.update(sample), ProgressMonitor::Verdict::kMoving);
  sample.stamp = stampFromSeconds(3.0);
  sample.odom_from_base.yaw_rad = 0.2;  // it turns: no stall
  EXPECT_EQ(monitor.update(sample), ProgressMonitor::Verdict::kMoving);
  sample.stamp = stampFromSeconds(6.0);
  EXPECT_EQ(monitor.update(sample), ProgressMonitor::Verdict::kMoving);
  sample.stamp = stampFromSeconds(7.0);
  EXPECT_EQ(monitor.update(sample), ProgressMonitor::Verdict::kStalled);
  sample.commanded = false;
  EXPECT_EQ(monitor.update(sample), ProgressMonitor::Verdict::kMoving);
}

}  // namespace
}  // namespace frugal_nav
