// Benchmarks of the simulator's ray-traced sensors: what decides how much faster than real time it runs.

#include <cmath>
#include <memory>

#include <benchmark/benchmark.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/sim/camera.hpp>
#include <frugal_nav/sim/lidar.hpp>
#include <frugal_nav/sim/lighting.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>
#include <frugal_nav/sim/rgbd_camera.hpp>

namespace frugal_nav::sim {
namespace {

constexpr int kCellsASide = 14;  // of each face of a box, so that forty of them make about 100,000 triangles
constexpr int kBoxes = 42;

/// A box whose faces are grids of triangles, with a texture of one repeat a metre.
Mesh gridBox(const Eigen::Vector3f& size_m, int material) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0F, 1.0F}) {
      const int first = static_cast<int>(mesh.vertices.size());
      const int b = (axis + 1) % 3;
      const int c = (axis + 2) % 3;
      for (int i = 0; i <= kCellsASide; ++i) {
        for (int k = 0; k <= kCellsASide; ++k) {
          Eigen::Vector3f p;
          p[axis] = 0.5F * side * size_m[axis];
          p[b] = (static_cast<float>(i) / kCellsASide - 0.5F) * size_m[b];
          p[c] = (static_cast<float>(k) / kCellsASide - 0.5F) * size_m[c];
          mesh.vertices.push_back(p);
          mesh.normals.push_back(side * Eigen::Vector3f::Unit(axis));
          mesh.uvs.emplace_back(p[b], p[c]);
        }
      }
      for (int i = 0; i < kCellsASide; ++i) {
        for (int k = 0; k < kCellsASide; ++k) {
          const int corner = first + i * (kCellsASide + 1) + k;
          mesh.triangles.emplace_back(corner, corner + kCellsASide + 1, corner + kCellsASide + 2);
          mesh.triangles.emplace_back(corner, corner + kCellsASide + 2, corner + 1);
        }
      }
    }
  }
  mesh.triangle_material.assign(mesh.triangles.size(), material);
  return mesh;
}

/// A textured hall of 10 m x 8 m with boxes in it, a sun and two lamps: 98,784 triangles in the boxes.
Scene makeHall() {
  Scene scene;
  Random random(500001, "hall");
  Texture noise{"noise", 256, 256, {}};
  for (int i = 0; i < 3 * 256 * 256; ++i)
    noise.rgb.push_back(static_cast<std::uint8_t>(random.integer(60, 220)));
  scene.textures.push_back(noise);
  Material paint;
  paint.albedo = {0.9F, 0.85F, 0.8F};
  paint.texture = 0;
  scene.materials.push_back(paint);
  const auto add = [&scene](const Eigen::Vector3f& size_m, const Eigen::Vector3d& p, double yaw_rad) {
    scene.meshes.push_back(gridBox(size_m, 0));
    Model model;
    model.world_from_model = Eigen::Translation3d(p) * Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
    model.visuals.push_back({static_cast<int>(scene.meshes.size()) - 1, Eigen::Isometry3d::Identity()});
    scene.models.push_back(model);
  };
  add({10.0F, 8.0F, 0.1F}, {0, 0, -0.05}, 0.0);
  add({10.0F, 8.0F, 0.1F}, {0, 0, 3.05}, 0.0);
  for (const double side : {-1.0, 1.0}) {
    add({10.0F, 0.1F, 3.0F}, {0, 4.0 * side, 1.5}, 0.0);
    add({0.1F, 8.0F, 3.0F}, {5.0 * side, 0, 1.5}, 0.0);
  }
  for (int i = 0; i < kBoxes; ++i) {
    const auto side = [&random] { return static_cast<float>(random.uniform(0.2, 0.8)); };
    const Eigen::Vector3d p(random.uniform(-3.0, 4.5), random.uniform(-3.5, 3.5), 0.4);
    add({side(), side(), 0.8F}, p, random.uniform(0.0, M_PI));
  }
  Light sun;
  sun.kind = Light::Kind::kDirectional;
  sun.direction = Eigen::Vector3d(0.3, -0.7, -0.6).normalized();
  scene.lights.push_back(sun);
  for (const double x : {-2.5, 2.5}) {
    Light lamp;
    lamp.position_m = {x, 0.0, 2.7};
    lamp.attenuation_quadratic = 0.1;
    scene.lights.push_back(lamp);
  }
  return scene;
}

/// The hall, built once for all benchmarks.
struct Hall {
  Scene scene = makeHall();
  RayTracer tracer{scene};
  Lighting lighting{LightingParams{}, tracer, 1};
};
Hall& hall() {
  static Hall built;
  return built;
}

Eigen::Isometry3d cameraPose(double yaw_rad) {
  Eigen::Matrix3d world_from_optical;  // looks along x
  world_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << -4.5, 0.0, 0.4;
  pose.linear() =
      Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix() * world_from_optical;
  return pose;
}

void buildTracer(benchmark::State& state) {
  for (auto _ : state) {
    RayTracer tracer(hall().scene);
    benchmark::DoNotOptimize(&tracer);
  }
}
BENCHMARK(buildTracer)->Unit(benchmark::kMillisecond)->UseRealTime();

void moveModel(benchmark::State& state) {
  Scene scene = hall().scene;
  RayTracer tracer(scene);
  const int moving = static_cast<int>(scene.models.size()) - 1;
  for (auto _ : state) {
    scene.models.back().world_from_model.translation().x() += 1e-3;
    tracer.updateModel(moving);
    tracer.commit();
  }
}
BENCHMARK(moveModel)->Unit(benchmark::kMicrosecond)->UseRealTime();

void scanLidar(benchmark::State& state) {
  Lidar lidar(LidarParams{}, 1);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << -4.0, 0.0, 0.18;
  for (auto _ : state) benchmark::DoNotOptimize(lidar.scan(hall().tracer, pose, Stamp{}));
}
BENCHMARK(scanLidar)->Unit(benchmark::kMicrosecond)->UseRealTime();

/// Arguments: threads, and whether the camera turns while its shutter is open.
void renderCamera(benchmark::State& state) {
  CameraParams params;
  params.threads = static_cast<int>(state.range(0));
  params.motion_blur = state.range(1) != 0;
  Camera camera(params, 1);
  const Eigen::Isometry3d close = cameraPose(0.02);  // 11 px further: the most instants
  for (auto _ : state) {
    benchmark::DoNotOptimize(camera.render(hall().tracer, hall().lighting, cameraPose(0.0), close, Stamp{}));
  }
}
BENCHMARK(renderCamera)
    ->ArgNames({"threads", "blur"})
    ->ArgsProduct({{1, 2}, {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void renderRgbd(benchmark::State& state) {
  RgbdCamera camera(RgbdParams{}, 1);
  const Eigen::Isometry3d pose = cameraPose(0.0);
  for (auto _ : state) {
    benchmark::DoNotOptimize(camera.render(hall().tracer, hall().lighting, pose, pose, Stamp{}));
  }
}
BENCHMARK(renderRgbd)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace frugal_nav::sim
