// Visual odometry over a short drive, and one bundle adjustment of its window.

#include "benchmark_robot.hpp"

#include <benchmark/benchmark.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/eval/random_world.hpp>
#include <frugal_nav/eval/visual_drive.hpp>
#include <frugal_nav/odometry/visual_bundle_adjustment.hpp>

namespace frugal_nav {
namespace {

/// One metre in a random room, at 640x480.
const eval::DriveRecording& drive() {
  static const eval::DriveRecording kDrive = [] {
    const RobotModel robot = boxRobot();
    const eval::RandomWorld world = eval::makeRandomWorld(500001, robot.circumradius_m() + 0.1);
    return eval::recordDrive(world.scene, robot, sim::SimulatorParams(), 1, world.start, {{1.0, 0.0}});
  }();
  return kDrive;
}

/// Time of an image.
void visualOdometry(benchmark::State& state, const char* method) {
  VisualOdometryParams params;
  params.features.method = method;
  double tracked_share = 0.0;
  for (auto _ : state) tracked_share = eval::runVisualOdometry(drive(), params).tracked_share;
  const auto images = static_cast<double>(drive().images.size());
  state.counters["s_per_image"] =
      benchmark::Counter(images, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["tracked_share"] = tracked_share;
}
BENCHMARK_CAPTURE(visualOdometry, tracking, "tracking")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(visualOdometry, matching, "matching")->Unit(benchmark::kMillisecond);

/// A full window over 300 points four metres ahead: ten keyframes 8 cm apart, 0.5 px of noise on what they
/// see and 2 cm on where the points are thought to be.
VisualMap fullWindow(double focal_px) {
  Random random(500001);
  VisualMap map(VisualMapParams(), focal_px);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 300; ++i)
    points.emplace_back(random.uniform(-2.0, 2.0), random.uniform(-1.5, 1.5), random.uniform(3.0, 5.0));
  for (int k = 0; k < 10; ++k) {
    Keyframe keyframe;
    keyframe.odom_from_camera.translation().x() = 0.08 * k;
    keyframe.wheels_from_camera = keyframe.odom_from_camera;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d p = points[i] - keyframe.odom_from_camera.translation();
      keyframe.rays[static_cast<std::int64_t>(i)] =
          p.head<2>() / p.z() + Ray2(random.normal(0.5), random.normal(0.5)) / focal_px;
    }
    map.addKeyframe(std::move(keyframe));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    Landmark landmark;
    landmark.p_odom =
        points[i] + Eigen::Vector3d(random.normal(0.02), random.normal(0.02), random.normal(0.02));
    map.landmarks()[static_cast<std::int64_t>(i)] = landmark;
  }
  return map;
}

void bundleAdjustment(benchmark::State& state) {
  BundleSettings settings;
  settings.focal_px = 530.0;
  const VisualMap start = fullWindow(settings.focal_px);
  for (auto _ : state) {
    VisualMap map = start;
    benchmark::DoNotOptimize(adjustBundle(map, settings).rms_after_px);
  }
}
BENCHMARK(bundleAdjustment)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace frugal_nav
