#include <cmath>

#include <gtest/gtest.h>

#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/sim/imu.hpp>

namespace frugal_nav::sim {
namespace {

ImuParams noiseless() {
  ImuParams params;
  params.gyro_noise_radps_sqrt_hz = 0.0;
  params.gyro_bias_start_radps = 0.0;
  params.gyro_bias_walk_radps2_sqrt_hz = 0.0;
  params.accel_noise_mps2_sqrt_hz = 0.0;
  params.accel_bias_start_mps2 = 0.0;
  params.accel_bias_walk_mps3_sqrt_hz = 0.0;
  return params;
}

Eigen::Isometry3d at(double x_m, double y_m) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(x_m, y_m, 0.06);
  return pose;
}

TEST(Imu, AtRestReadsGravityUpward) {
  Imu imu(noiseless(), at(0.1, 0.2), 1);
  const ImuSample sample = imu.sample(stampFromSeconds(1.0), {}, {});
  EXPECT_TRUE(sample.acceleration_mps2.isApprox(Eigen::Vector3d(0, 0, kGravity_mps2), 1e-12));
  EXPECT_TRUE(sample.angular_velocity_radps.isZero(1e-12));
}

TEST(Imu, OnAnArcReadsWhatACentrifugeDoes) {
  // A sensor 0.2 m ahead of the turning axis of a base at v, w, with angular acceleration a:
  // along x -w^2 0.2; along y v w + a 0.2.
  Imu imu(noiseless(), at(0.2, 0.0), 1);
  const ImuSample sample = imu.sample(stampFromSeconds(1.0), {0.5, 2.0}, {0.3, 1.5});
  EXPECT_NEAR(sample.acceleration_mps2.x(), 0.3 - 4.0 * 0.2, 1e-12);
  EXPECT_NEAR(sample.acceleration_mps2.y(), 0.5 * 2.0 + 1.5 * 0.2, 1e-12);
  EXPECT_NEAR(sample.angular_velocity_radps.z(), 2.0, 1e-12);
}

TEST(Imu, ReadsInItsOwnFrame) {
  Eigen::Isometry3d turned = at(0.0, 0.0);
  turned.linear() = Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Imu imu(noiseless(), turned, 1);
  const ImuSample sample = imu.sample(stampFromSeconds(1.0), {}, {0.4, 0.0});
  EXPECT_NEAR(sample.acceleration_mps2.x(), 0.0, 1e-12);
  EXPECT_NEAR(sample.acceleration_mps2.y(), -0.4, 1e-12);
}

TEST(Imu, WhiteNoiseHasTheDensityOfTheProfile) {
  ImuParams params = noiseless();
  params.gyro_noise_radps_sqrt_hz = 1e-3;
  Imu imu(params, at(0, 0), 5);
  double sum = 0.0;
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    sum += std::pow(imu.sample(stampFromSeconds(1.0 + 0.01 * i), {}, {}).angular_velocity_radps.z(), 2);
  }
  // sigma = density * sqrt(100 Hz) = 0.01; its estimate from n samples has a standard error of 0.01 /
  // sqrt(2n).
  EXPECT_NEAR(std::sqrt(sum / kSamples), 0.01, 4.0 * 0.01 / std::sqrt(2.0 * kSamples));
}

TEST(Imu, BiasWalksWithTheRootOfTime) {
  ImuParams params = noiseless();
  params.accel_bias_walk_mps3_sqrt_hz = 1e-2;
  constexpr int kRuns = 400;
  double sum = 0.0;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    Imu imu(params, at(0, 0), seed);
    ImuSample last;
    for (int i = 0; i < 900; ++i) last = imu.sample(stampFromSeconds(1.0 + 0.01 * i), {}, {});
    sum += std::pow(last.acceleration_mps2.x(), 2);
  }
  // After 9 s: sigma = 1e-2 * sqrt(9) = 0.03, here from 400 runs.
  EXPECT_NEAR(std::sqrt(sum / kRuns), 0.03, 4.0 * 0.03 / std::sqrt(2.0 * kRuns));
}

TEST(Imu, ClipsAtFullScale) {
  Imu imu(noiseless(), at(0, 0), 1);
  const ImuSample sample = imu.sample(stampFromSeconds(1.0), {0.0, 50.0}, {-900.0, 0.0});
  EXPECT_EQ(sample.angular_velocity_radps.z(), noiseless().gyro_range_radps);
  EXPECT_EQ(sample.acceleration_mps2.x(), -noiseless().accel_range_mps2);
}

TEST(Imu, ShippedProfileHoldsTheDefaults) {
  const auto profile =
      loadParamFile<ImuParams>(std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/sensors/mpu6050.yaml");
  EXPECT_EQ(toYaml(profile), toYaml(ImuParams{}));
}

}  // namespace
}  // namespace frugal_nav::sim
