#include <algorithm>
#include <cmath>

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/distortion_models.h>
#include <sensor_msgs/image_encodings.h>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/simulator_messages.hpp>

namespace frugal_nav {
namespace {

constexpr char kOpticalFrame[] = "camera_optical_frame";

std_msgs::Header header(Stamp stamp, const char* frame) {
  std_msgs::Header result;
  result.stamp = toRos(stamp);
  result.frame_id = frame;
  return result;
}

void setDiagonal(boost::array<double, 9>& covariance, double variance) {
  covariance.fill(0.0);
  covariance[0] = covariance[4] = covariance[8] = variance;
}

}  // namespace

WheelTicks toRos(const sim::WheelTicks& ticks) {
  WheelTicks msg;
  msg.header = header(ticks.stamp, "base_link");
  msg.left = ticks.left;
  msg.right = ticks.right;
  return msg;
}

sensor_msgs::Imu toRos(const sim::ImuSample& sample, const sim::ImuParams& profile) {
  sensor_msgs::Imu msg;
  msg.header = header(sample.stamp, "imu_link");
  msg.orientation_covariance[0] = -1.0;  // there is none
  msg.angular_velocity.x = sample.angular_velocity_radps.x();
  msg.angular_velocity.y = sample.angular_velocity_radps.y();
  msg.angular_velocity.z = sample.angular_velocity_radps.z();
  msg.linear_acceleration.x = sample.acceleration_mps2.x();
  msg.linear_acceleration.y = sample.acceleration_mps2.y();
  msg.linear_acceleration.z = sample.acceleration_mps2.z();
  setDiagonal(msg.angular_velocity_covariance,
              std::pow(profile.gyro_noise_radps_sqrt_hz, 2) * profile.rate_hz);
  setDiagonal(msg.linear_acceleration_covariance,
              std::pow(profile.accel_noise_mps2_sqrt_hz, 2) * profile.rate_hz);
  return msg;
}

sensor_msgs::LaserScan toRos(const LaserScan& scan, Duration period) {
  sensor_msgs::LaserScan msg;
  msg.header = header(scan.stamp, "laser");
  msg.angle_min = static_cast<float>(scan.angle_min_rad);
  msg.angle_increment = static_cast<float>(scan.angle_increment_rad);
  msg.angle_max = static_cast<float>(scan.angleOf(scan.ranges_m.size() - 1));
  msg.scan_time = static_cast<float>(toSeconds(period));
  msg.time_increment = 0.0F;  // all beams are of one instant
  msg.range_min = static_cast<float>(scan.range_min_m);
  msg.range_max = static_cast<float>(scan.range_max_m);
  msg.ranges = scan.ranges_m;
  return msg;
}

sensor_msgs::ImagePtr toRos(const sim::CameraImage& image) {
  return cv_bridge::CvImage(header(image.stamp, kOpticalFrame), sensor_msgs::image_encodings::BGR8, image.bgr)
      .toImageMsg();
}

sensor_msgs::ImagePtr toRos(const sim::DepthImage& image) {
  return cv_bridge::CvImage(header(image.stamp, kOpticalFrame), sensor_msgs::image_encodings::TYPE_32FC1,
                            image.depth_m)
      .toImageMsg();
}

sensor_msgs::CameraInfo cameraInfo(const sim::Camera& camera, Stamp stamp) {
  sensor_msgs::CameraInfo msg;
  msg.header = header(stamp, kOpticalFrame);
  msg.width = static_cast<std::uint32_t>(camera.params().width_px);
  msg.height = static_cast<std::uint32_t>(camera.params().height_px);
  msg.distortion_model = sensor_msgs::distortion_models::PLUMB_BOB;
  const cv::Vec<double, 5> distortion = camera.distortion();
  msg.D.assign(distortion.val, distortion.val + 5);
  const cv::Matx33d k = camera.cameraMatrix();
  std::copy(k.val, k.val + 9, msg.K.begin());
  msg.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  msg.P = {k(0, 0), 0, k(0, 2), 0, 0, k(1, 1), k(1, 2), 0, 0, 0, 1, 0};
  return msg;
}

nav_msgs::Odometry toRos(const sim::GroundTruth& truth) {
  nav_msgs::Odometry msg;
  msg.header = header(truth.stamp, "world");
  msg.child_frame_id = "base_link";
  msg.pose.pose = toRos(truth.world_from_base);
  msg.twist.twist = toRos(truth.twist);
  return msg;
}

Contact toRos(const sim::Contact& contact) {
  Contact msg;
  msg.header = header(contact.stamp, "world");
  msg.link = contact.robot_link;
  msg.other = contact.other;
  msg.position.x = contact.p_world.x();
  msg.position.y = contact.p_world.y();
  msg.position.z = contact.p_world.z();
  msg.depth = contact.depth_m;
  msg.speed = contact.speed_mps;
  msg.driven_into = contact.driven_into;
  return msg;
}

}  // namespace frugal_nav
