#include <gtest/gtest.h>

#include <frugal_nav/eval/lidar_stack.hpp>
#include <frugal_nav/eval/random_world.hpp>
#include <frugal_nav/eval/runner.hpp>
#include <frugal_nav/sim/simulator.hpp>

namespace frugal_nav::eval {
namespace {

const std::string kSource = FRUGAL_NAV_SOURCE_DIR;

RunRequest request(int trials) {
  RunRequest run;
  run.suite = "lidar";
  run.context.share_dir = kSource;
  run.context.seed = 500000;
  run.trials = trials;
  run.options["methods"] = std::vector<std::string>{"straight", "sectors_only", "sectors"};
  run.options["parts"] = std::vector<std::string>{"rooms"};
  return run;
}

TEST(LidarSuite, StackGetsWhereDrivingStraightDoesNot) {
  // Of the tuning seeds from 500000 on, the stack reaches the goal in each and straight in one of ten.
  const Result result = runSuite(request(4));
  EXPECT_EQ(result.rows.size(), 12U);
  EXPECT_EQ(result.summary.at("success_sectors"), 1.0);
  EXPECT_EQ(result.summary.at("contacts_sectors"), 0);
  EXPECT_EQ(result.summary.at("contacts_sectors_only"), 0);
  EXPECT_GT(result.summary.at("min_clearance_sectors_m").get<double>(), 0.0);
  EXPECT_LT(result.summary.at("success_straight").get<double>(), 0.5);
  EXPECT_GT(result.summary.at("contacts_straight").get<int>(), 0);
}

TEST(LidarSuite, LooksAheadThroughTightDoorsAndPastPeople) {
  RunRequest run = request(3);
  run.options["methods"] = std::vector<std::string>{"vfh_star"};
  run.options["parts"] = std::vector<std::string>{"doorway", "moving", "near_target"};
  const Result result = runSuite(run);
  for (const std::string part : {"doorway", "moving", "near_target"}) {
    EXPECT_EQ(result.summary.at("success_" + part + "_vfh_star"), 1.0);
    EXPECT_EQ(result.summary.at("contacts_" + part + "_vfh_star"), 0);
  }
}

TEST(LidarSuite, ThreadsAndShardsDoNotChangeTheRows) {
  RunRequest run = request(3);
  run.options["methods"] = std::vector<std::string>{"sectors"};
  run.threads = 1;
  const std::string whole = toJsonText(runSuite(run));
  run.threads = 3;
  run.shard = {0, 2};
  const Result even = runSuite(run);
  run.shard = {1, 2};
  EXPECT_EQ(whole, toJsonText(mergeResults({even, runSuite(run)})));
}

TEST(LidarSuite, UnknownMethodIsNamed) {
  RunRequest run = request(1);
  run.options["methods"] = std::vector<std::string>{"sectors", "luck"};
  try {
    runSuite(run);
    FAIL() << "an unknown method was taken";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("luck"), std::string::npos);
  }
}

TEST(LidarStack, StandsWithoutAGoal) {
  const RobotModel robot = loadRobot(kSource + "/urdf/frugal_bot.urdf");
  const RandomWorld world = makeRandomWorld(500001, robot.circumradius_m() + 0.1);
  sim::Simulator simulator(world.scene, robot, sim::SimulatorParams{}, 1, world.start);
  LidarStack stack(loadLidarStack(kSource + "/config"), robot);
  for (int i = 0; i < 200; ++i) {
    const sim::SimOutput output = simulator.step();
    if (output.ticks) {
      EXPECT_TRUE(stack.addTicks(output.stamp, output.ticks->left, output.ticks->right).velocity.isZero());
    }
    if (output.scan) {
      EXPECT_TRUE(stack.addScan(*output.scan).velocity.isZero());
    }
  }
}

}  // namespace
}  // namespace frugal_nav::eval
