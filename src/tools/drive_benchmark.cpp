// Wheel odometry, one control cycle of the base, and the whole LIDAR drive in the simulator.

#include "benchmark_robot.hpp"

#include <benchmark/benchmark.h>

#include <frugal_nav/eval/lidar_stack.hpp>
#include <frugal_nav/eval/random_world.hpp>
#include <frugal_nav/robot/robot_model.hpp>
#include <frugal_nav/sim/resource_path.hpp>
#include <frugal_nav/sim/simulator.hpp>
#include <frugal_nav/sim/world_cache.hpp>

namespace frugal_nav {
namespace {

/// A drive through a random room; the same every time.
struct Drive {
  RobotModel robot = boxRobot();
  eval::LidarStackParams params;
  eval::RandomWorld world = eval::makeRandomWorld(500001, robot.circumradius_m() + 0.1);
  sim::SimulatorParams simulator_params;
};

void wheelOdometry(benchmark::State& state) {
  const Drive drive;
  WheelOdometry odometry(drive.params.odometry, {drive.robot.drive.radius_m, drive.robot.drive.separation_m});
  std::int64_t tick = 0;
  for (auto _ : state) {
    tick += 20;
    benchmark::DoNotOptimize(
        odometry.addTicks(Stamp(tick * std::chrono::milliseconds(1)), tick, tick + tick / 9));
  }
}
BENCHMARK(wheelOdometry)->Unit(benchmark::kMicrosecond);

/// Drives until the robot is on its way, then repeats control cycles on the newest ticks and scan.
void controlCycle(benchmark::State& state) {
  const Drive drive;
  sim::Simulator simulator(drive.world.scene, drive.robot, drive.simulator_params, 1, drive.world.start);
  eval::LidarStack stack(drive.params, drive.robot);
  stack.setGoal(drive.world.start.inverse() * drive.world.goal, simulator.stamp());
  sim::WheelTicks ticks;
  while (toSeconds(simulator.stamp() - sim::kStartTime) < 5.0) {
    const sim::SimOutput output = simulator.step();
    if (output.ticks) {
      ticks = *output.ticks;
      simulator.setCommand(stack.addTicks(ticks.stamp, ticks.left, ticks.right).velocity);
    }
    if (output.scan) simulator.setCommand(stack.addScan(*output.scan).velocity);
  }
  for (auto _ : state) {
    ticks.stamp += std::chrono::microseconds(1);  // the scan must not grow stale
    benchmark::DoNotOptimize(stack.addTicks(ticks.stamp, ticks.left, ticks.right));
  }
}
BENCHMARK(controlCycle)->Unit(benchmark::kMicrosecond)->Iterations(20000);

/// The counter says how many seconds are simulated in one.
void lidarDrive(benchmark::State& state) {
  const Drive drive;
  double simulated_s = 0.0;
  for (auto _ : state) {
    sim::Simulator simulator(drive.world.scene, drive.robot, drive.simulator_params, 1, drive.world.start);
    eval::LidarStack stack(drive.params, drive.robot);
    stack.setGoal(drive.world.start.inverse() * drive.world.goal, simulator.stamp());
    while (stack.mission().active()) {
      const sim::SimOutput output = simulator.step();
      if (output.ticks)
        simulator.setCommand(
            stack.addTicks(output.ticks->stamp, output.ticks->left, output.ticks->right).velocity);
      if (output.scan) simulator.setCommand(stack.addScan(*output.scan).velocity);
    }
    simulated_s += toSeconds(simulator.stamp() - sim::kStartTime);
  }
  state.counters["x_real_time"] = benchmark::Counter(simulated_s, benchmark::Counter::kIsRate);
}
BENCHMARK(lidarDrive)->Unit(benchmark::kMillisecond)->Iterations(5);

/// The furnished lab, the robot driving a curve, ten seconds of it: LIDAR, IMU and encoders, and the camera
/// at 640x480 and 10 Hz without and with motion blur. The counter says how many seconds are simulated in one.
void simulateLab(benchmark::State& state) {
  const sim::ResourcePath resources = sim::ResourcePath::fromEnvironment();
  const auto world = resources.find("package://frugal_nav/worlds/lab.world", "");
  const auto urdf = resources.find("package://frugal_nav/urdf/frugal_bot.urdf", "");
  if (!world || !urdf) {
    state.SkipWithError(
        "lab.world or frugal_bot.urdf not found: start with rosrun or source the workspace's setup");
    return;
  }
  const RobotModel robot = loadRobot(*urdf);
  const sim::LoadedWorld lab = sim::loadWorldCached(*world, resources, sim::defaultCacheFolder());
  sim::SimulatorParams params;
  params.sensors.camera = state.range(0) != 0;
  params.camera.motion_blur = state.range(1) != 0;
  sim::Simulator simulator(lab.scene, robot, params, 1, {-4.0, -2.4, 0.3});
  double simulated_s = 0.0;
  for (auto _ : state) {
    simulator.reset({-4.0, -2.4, 0.3});
    const Stamp start = simulator.stamp();
    while (simulator.stamp() - start < std::chrono::seconds(10)) {
      simulator.setCommand({0.3, 0.1});
      benchmark::DoNotOptimize(simulator.step());
    }
    simulated_s += 10.0;
  }
  state.counters["x_real_time"] = benchmark::Counter(simulated_s, benchmark::Counter::kIsRate);
}
BENCHMARK(simulateLab)
    ->ArgNames({"camera", "blur"})
    ->Args({0, 0})
    ->Args({1, 0})
    ->Args({1, 1})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace frugal_nav
