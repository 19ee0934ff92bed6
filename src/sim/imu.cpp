#include <cmath>

#include <frugal_nav/sim/imu.hpp>

namespace frugal_nav::sim {
namespace {

Eigen::Vector3d clipped(const Eigen::Vector3d& value, double range) {
  return value.cwiseMax(-range).cwiseMin(range);
}

}  // namespace

Imu::Imu(const ImuParams& params, const Eigen::Isometry3d& base_from_imu, std::uint64_t seed)
    : params_(params), base_from_imu_(base_from_imu), random_(seed, "imu") {
  validate(params, "imu");
  gyro_bias_ = noise(params_.gyro_bias_start_radps);
  accel_bias_ = noise(params_.accel_bias_start_mps2);
}

ImuSample Imu::sample(Stamp stamp, const Twist2& twist, const Twist2& twist_rate) {
  // Specific force at the sensor: gravity, the base's own acceleration (its velocity turns with it), and the
  // tangential and centripetal parts of the lever arm.
  const Eigen::Vector3d arm = base_from_imu_.translation();
  const double w = twist.w_radps;
  const Eigen::Vector3d acceleration_base(twist_rate.v_mps - twist_rate.w_radps * arm.y() - w * w * arm.x(),
                                          twist.v_mps * w + twist_rate.w_radps * arm.x() - w * w * arm.y(),
                                          kGravity_mps2);
  const Eigen::Matrix3d imu_from_base = base_from_imu_.linear().transpose();

  // White noise of density n, sampled at f Hz, has sigma n sqrt(f); a walk of density b grows by b / sqrt(f).
  const double root_rate = std::sqrt(params_.rate_hz);
  gyro_bias_ += noise(params_.gyro_bias_walk_radps2_sqrt_hz / root_rate);
  accel_bias_ += noise(params_.accel_bias_walk_mps3_sqrt_hz / root_rate);
  ImuSample sample;
  sample.stamp = stamp;
  sample.angular_velocity_radps = clipped(imu_from_base * Eigen::Vector3d(0.0, 0.0, w) + gyro_bias_ +
                                              noise(params_.gyro_noise_radps_sqrt_hz * root_rate),
                                          params_.gyro_range_radps);
  sample.acceleration_mps2 = clipped(
      imu_from_base * acceleration_base + accel_bias_ + noise(params_.accel_noise_mps2_sqrt_hz * root_rate),
      params_.accel_range_mps2);
  return sample;
}

Eigen::Vector3d Imu::noise(double sigma) {
  const double x = random_.normal(sigma);
  const double y = random_.normal(sigma);
  return {x, y, random_.normal(sigma)};
}

}  // namespace frugal_nav::sim
