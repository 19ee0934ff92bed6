#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Geometry>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/sim/sensor_data.hpp>

namespace frugal_nav::sim {

/// An inertial measurement unit; the defaults are an MPU6050's, from its data sheet, after the usual
/// subtraction of the bias at rest.
struct ImuParams {
  double rate_hz = 100.0;
  double gyro_noise_radps_sqrt_hz = 8.7e-5;
  double gyro_bias_start_radps = 0.002;
  double gyro_bias_walk_radps2_sqrt_hz = 2e-5;
  double gyro_range_radps = 4.363;
  double accel_noise_mps2_sqrt_hz = 3.9e-3;
  double accel_bias_start_mps2 = 0.03;
  double accel_bias_walk_mps3_sqrt_hz = 3e-4;
  double accel_range_mps2 = 19.61;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("rate_hz", rate_hz, Field{"Hz", "samples a second", 1.0, 200.0});
    visit("gyro_noise_radps_sqrt_hz", gyro_noise_radps_sqrt_hz,
          Field{"rad/s/sqrt(Hz)", "white noise of the gyroscope: 0.005 deg/s/sqrt(Hz)", 0.0, 1.0});
    visit("gyro_bias_start_radps", gyro_bias_start_radps,
          Field{"rad/s", "standard deviation of the bias that is left at the start", 0.0, 1.0});
    visit("gyro_bias_walk_radps2_sqrt_hz", gyro_bias_walk_radps2_sqrt_hz,
          Field{"rad/s^2/sqrt(Hz)", "random walk of the gyroscope's bias", 0.0, 1.0});
    visit("gyro_range_radps", gyro_range_radps, Field{"rad/s", "full scale: 250 deg/s", 0.1, 100.0});
    visit("accel_noise_mps2_sqrt_hz", accel_noise_mps2_sqrt_hz,
          Field{"m/s^2/sqrt(Hz)", "white noise of the accelerometer: 400 micro-g/sqrt(Hz)", 0.0, 1.0});
    visit("accel_bias_start_mps2", accel_bias_start_mps2,
          Field{"m/s^2", "standard deviation of the bias that is left at the start", 0.0, 5.0});
    visit("accel_bias_walk_mps3_sqrt_hz", accel_bias_walk_mps3_sqrt_hz,
          Field{"m/s^3/sqrt(Hz)", "random walk of the accelerometer's bias", 0.0, 1.0});
    visit("accel_range_mps2", accel_range_mps2, Field{"m/s^2", "full scale: 2 g", 1.0, 200.0});
  }
};

/// Standard gravity [m/s^2].
constexpr double kGravity_mps2 = 9.80665;

/// An IMU on a planar robot: white noise and a walking bias on both sensors, clipped at full scale.
class Imu {
 public:
  /// Throws ConfigError on parameters out of range.
  Imu(const ImuParams& params, const Eigen::Isometry3d& base_from_imu, std::uint64_t seed);

  /// One sample at `stamp`, of a base that moves with `twist` and whose twist changes by `twist_rate` each
  /// second; both in base_link.
  ImuSample sample(Stamp stamp, const Twist2& twist, const Twist2& twist_rate);

 private:
  Eigen::Vector3d noise(double sigma);

  ImuParams params_;
  Eigen::Isometry3d base_from_imu_;
  Random random_;
  Eigen::Vector3d gyro_bias_;
  Eigen::Vector3d accel_bias_;
};

}  // namespace frugal_nav::sim
