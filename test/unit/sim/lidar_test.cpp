#include "box_scene.hpp"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/sim/lidar.hpp>

namespace frugal_nav::sim {
namespace {

LidarParams quiet() {
  LidarParams params;
  params.sigma_ratio = params.sigma_min_m = params.dropout_probability = 0.0;
  return params;
}

/// A room 6 m x 4 m, its walls' inner faces at x = -3, 3 and y = -2, 2.
BoxScene room() {
  BoxScene world;
  const int wall = world.addMaterial({0.8F, 0.8F, 0.8F});
  world.addBox({1.0F, 8.0F, 2.0F}, at(3.5, 0.0, 1.0), wall);
  world.addBox({1.0F, 8.0F, 2.0F}, at(-3.5, 0.0, 1.0), wall);
  world.addBox({8.0F, 1.0F, 2.0F}, at(0.0, 2.5, 1.0), wall);
  world.addBox({8.0F, 1.0F, 2.0F}, at(0.0, -2.5, 1.0), wall);
  return world;
}

TEST(Lidar, MeasuresARoomCounterClockwise) {
  const BoxScene world = room();
  const RayTracer tracer(world.scene);
  Eigen::Isometry3d pose = at(0.5, 0.25, 0.2);
  const LaserScan scan = Lidar(quiet(), 1).scan(tracer, pose, stampFromSeconds(2.0));
  ASSERT_EQ(scan.ranges_m.size(), 360U);
  EXPECT_EQ(scan.stamp, stampFromSeconds(2.0));
  EXPECT_FALSE(findFault(scan));
  EXPECT_NEAR(scan.ranges_m[180], 2.5F, 1e-5F) << "ahead";
  EXPECT_NEAR(scan.ranges_m[270], 1.75F, 1e-5F) << "left";
  EXPECT_NEAR(scan.ranges_m[0], 3.5F, 1e-5F) << "behind";
  EXPECT_NEAR(scan.ranges_m[90], 2.25F, 1e-5F) << "right";
  pose.linear() = Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_NEAR(Lidar(quiet(), 1).scan(tracer, pose, Stamp{}).ranges_m[180], 1.75F, 1e-5F);
}

TEST(Lidar, ANarrowFieldOfViewEndsAtItsLastBeam) {
  const BoxScene world = room();
  const RayTracer tracer(world.scene);
  LidarParams params = quiet();
  params.angle_min_rad = -0.5 * M_PI;
  params.field_of_view_rad = M_PI;
  params.beams = 9;
  const LaserScan scan = Lidar(params, 1).scan(tracer, at(0.5, 0.25, 0.2), Stamp{});
  EXPECT_FALSE(findFault(scan));
  EXPECT_NEAR(scan.angleOf(8), 0.5 * M_PI, 1e-9);
  EXPECT_NEAR(scan.ranges_m[0], 2.25F, 1e-5F) << "right";
  EXPECT_NEAR(scan.ranges_m[4], 2.5F, 1e-5F) << "ahead";
  EXPECT_NEAR(scan.ranges_m[8], 1.75F, 1e-5F) << "left";
}

TEST(Lidar, NoiseIsOnePercentOfTheRange) {
  const BoxScene world = room();
  const RayTracer tracer(world.scene);
  const Eigen::Isometry3d pose = at(0.0, 0.0, 0.2);
  const LaserScan truth = Lidar(quiet(), 1).scan(tracer, pose, Stamp{});
  Lidar lidar(LidarParams{}, 42);
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  int missing = 0;
  for (int i = 0; i < 50; ++i) {
    const LaserScan scan = lidar.scan(tracer, pose, Stamp{});
    for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
      if (std::isnan(scan.ranges_m[beam])) {
        ++missing;
        continue;
      }
      const double error = static_cast<double>(scan.ranges_m[beam] / truth.ranges_m[beam]) - 1.0;
      sum += error;
      squares += error * error;
      ++count;
    }
  }
  // n = 18,000: the standard error of the mean is 0.01 / sqrt(n), that of sigma 0.01 / sqrt(2 n); 4 of each.
  EXPECT_NEAR(sum / count, 0.0, 4.0 * 0.01 / std::sqrt(count));
  EXPECT_NEAR(std::sqrt(squares / count), 0.01, 4.0 * 0.01 / std::sqrt(2.0 * count));
  // Binomial: 90 of 18,000 expected, standard deviation 9.5.
  EXPECT_NEAR(missing, 90, 38);
}

TEST(Lidar, SaysWhyThereIsNoRange) {
  BoxScene world;
  const int wall = world.addMaterial({0.8F, 0.8F, 0.8F});
  world.addBox({1.0F, 1.0F, 1.0F}, at(0.6, 0.0, 0.0), wall);    // 0.1 m ahead
  world.addBox({1.0F, 1.0F, 1.0F}, at(-13.0, 0.0, 0.0), wall);  // 12.5 m behind
  const RayTracer tracer(world.scene);
  const LaserScan scan = Lidar(quiet(), 1).scan(tracer, at(0.0, 0.0, 0.0), Stamp{});
  EXPECT_EQ(classify(scan, scan.ranges_m[180]), Return::kTooClose);
  EXPECT_TRUE(std::isinf(scan.ranges_m[180]) && scan.ranges_m[180] < 0);
  EXPECT_EQ(classify(scan, scan.ranges_m[0]), Return::kFree) << "beyond the largest range";
  EXPECT_EQ(classify(scan, scan.ranges_m[90]), Return::kFree) << "nothing at all";
  LidarParams deaf = quiet();
  deaf.dropout_probability = 1.0;
  const LaserScan silent = Lidar(deaf, 1).scan(tracer, at(0.0, 0.0, 0.0), Stamp{});
  for (const float range : silent.ranges_m) EXPECT_TRUE(std::isnan(range));
}

TEST(Lidar, NoiseNeverLeavesTheRangeLimits) {
  BoxScene world;
  world.addBox({1.0F, 40.0F, 1.0F}, at(12.5, 0.0, 0.0), world.addMaterial({0.8F, 0.8F, 0.8F}));
  const RayTracer tracer(world.scene);
  Lidar lidar(LidarParams{}, 3);
  int measured = 0;
  int beyond = 0;
  for (int i = 0; i < 200; ++i) {
    const float range = lidar.scan(tracer, at(0.0, 0.0, 0.0), Stamp{}).ranges_m[180];  // true range 12.0 m
    if (std::isnan(range)) continue;
    (std::isinf(range) ? beyond : measured) += 1;
    EXPECT_TRUE(std::isinf(range) || range <= 12.0F);
  }
  // Half to each side: 100 +- 7 of 200; 5 standard deviations.
  EXPECT_NEAR(measured, beyond, 70);
}

TEST(Lidar, SameSeedGivesTheSameRanges) {
  const BoxScene world = room();
  const RayTracer tracer(world.scene);
  const auto ranges = [&](std::uint64_t seed) {
    Lidar lidar(LidarParams{}, seed);
    lidar.scan(tracer, at(0.0, 0.0, 0.2), Stamp{});
    return lidar.scan(tracer, at(0.0, 0.0, 0.2), Stamp{}).ranges_m;
  };
  const std::vector<float> a = ranges(5);
  const std::vector<float> b = ranges(5);
  const std::vector<float> c = ranges(6);
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0);
  EXPECT_NE(std::memcmp(a.data(), c.data(), a.size() * sizeof(float)), 0);
}

TEST(Lidar, ProfileHoldsTheDefaults) {
  const std::string path = std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/sensors/rplidar_a1.yaml";
  EXPECT_EQ(toYaml(loadParamFile<LidarParams>(path)), toYaml(LidarParams{}));
  EXPECT_EQ(readParamFile(path).size(), describe(LidarParams{}).size()) << "every key stands in the file";
}

TEST(Lidar, RefusesContradictingLimits) {
  LidarParams params;
  params.range_min_m = 5.0;
  params.range_max_m = 4.0;
  EXPECT_THROW(Lidar(params, 1), ConfigError);
}

}  // namespace
}  // namespace frugal_nav::sim
