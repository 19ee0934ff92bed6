// Visual odometry over a short drive, and one bundle adjustment of its window.

#include "benchmark_robot.hpp"

#include <cstdint>
#include <vector>

#include <benchmark/benchmark.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/eval/visual_drive.hpp>
#include <frugal_nav/odometry/visual_bundle_adjustment.hpp>
#include <frugal_nav/sim/primitive_mesh.hpp>

namespace frugal_nav {
namespace {

/// A room of boxes with spots painted on them: the program reads no files.
sim::Scene spottedRoom() {
  constexpr int kSide_px = 256;
  constexpr int kSpot_px = 4;
  Random random(500001);
  sim::Texture spots{"spots", kSide_px, kSide_px, std::vector<std::uint8_t>(3 * kSide_px * kSide_px)};
  for (int y = 0; y < kSide_px; y += kSpot_px) {
    for (int x = 0; x < kSide_px; x += kSpot_px) {
      const auto grey = static_cast<std::uint8_t>(random.integer(30, 220));
      for (int i = 0; i < kSpot_px * kSpot_px; ++i) {
        const auto pixel = static_cast<std::size_t>((y + i / kSpot_px) * kSide_px + x + i % kSpot_px);
        for (std::size_t c = 0; c < 3; ++c) spots.rgb[3 * pixel + c] = grey;
      }
    }
  }
  sim::Scene scene;
  scene.textures.push_back(std::move(spots));
  scene.materials.emplace_back();
  scene.materials.back().texture = 0;
  const auto add = [&scene](const Eigen::Vector3d& size_m, const Eigen::Vector3d& middle) {
    sim::Model model;
    model.visuals.push_back({static_cast<int>(scene.meshes.size()), Eigen::Isometry3d::Identity()});
    model.world_from_model.translation() = middle;
    scene.meshes.push_back(sim::makeBox(size_m));
    scene.models.push_back(std::move(model));
  };
  add({8.0, 8.0, 0.1}, {0.0, 0.0, -0.05});
  add({0.1, 8.0, 3.0}, {4.0, 0.0, 1.5});
  add({8.0, 0.1, 3.0}, {0.0, 3.0, 1.5});
  add({8.0, 0.1, 3.0}, {0.0, -3.0, 1.5});
  add({0.5, 0.5, 0.8}, {2.5, 0.8, 0.4});
  add({0.5, 0.5, 0.8}, {3.0, -1.0, 0.4});
  return scene;
}

/// One metre through it, at 640x480.
const eval::DriveRecording& drive() {
  static const eval::DriveRecording kDrive =
      eval::recordDrive(spottedRoom(), boxRobot(), sim::SimulatorParams(), 1, {-1.0, 0.0, 0.0}, {{1.0, 0.0}});
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
