#pragma once

#include <string>

#include <Eigen/Geometry>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <opencv2/core.hpp>
#include <ros/ros.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <support/ros_test.hpp>
#include <tf2_ros/static_transform_broadcaster.h>

#include <frugal_nav/ros/conversions.hpp>

namespace frugal_nav::test {

/// What surrounds a node that takes images: a clock that stands between beats, a camera 0.4 m above the
/// floor that looks level ahead, a robot at `pose`.
class CameraGraph {
 public:
  /// Topics are those of a namespace; empty: the test's own.
  explicit CameraGraph(const std::string& name_space = "") : nh(name_space) {
    image_pub_ = nh.advertise<sensor_msgs::Image>("camera/image_raw", 10);
    info_pub_ = nh.advertise<sensor_msgs::CameraInfo>("camera/camera_info", 10);
    odometry_pub_ = nh.advertise<nav_msgs::Odometry>("odom", 10);
    geometry_msgs::TransformStamped camera;
    camera.header.frame_id = "base_link";
    camera.child_frame_id = "camera_optical_frame";
    camera.transform.translation.z = 0.4;
    camera.transform.rotation.x = -0.5;  // x right, y down, z ahead
    camera.transform.rotation.y = 0.5;
    camera.transform.rotation.z = -0.5;
    camera.transform.rotation.w = 0.5;
    tf_.sendTransform(camera);
  }

  /// base_from_optical
  static Eigen::Isometry3d mount() {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    pose.translation().z() = 0.4;
    return pose;
  }

  bool connect() {
    return waitForSubscriber(image_pub_) && waitForSubscriber(info_pub_) && waitForSubscriber(odometry_pub_);
  }
  std::uint32_t imageListeners() const { return image_pub_.getNumSubscribers(); }

  /// An image message of the present time.
  sensor_msgs::Image imageOf(const cv::Mat& pixels, const std::string& encoding = "bgr8") const {
    sensor_msgs::Image msg;
    msg.header.stamp = clock.now();
    msg.header.frame_id = "camera_optical_frame";
    msg.width = static_cast<std::uint32_t>(pixels.cols);
    msg.height = static_cast<std::uint32_t>(pixels.rows);
    msg.encoding = encoding;
    msg.step = msg.width * static_cast<std::uint32_t>(pixels.elemSize());
    const cv::Mat whole = pixels.isContinuous() ? pixels : pixels.clone();
    msg.data.assign(whole.data, whole.data + whole.total() * whole.elemSize());
    return msg;
  }
  void publish(const sensor_msgs::Image& msg) { image_pub_.publish(msg); }
  void publish(const sensor_msgs::CameraInfo& msg) { info_pub_.publish(msg); }

  sensor_msgs::CameraInfo info() const {
    sensor_msgs::CameraInfo msg;
    msg.header.stamp = clock.now();
    msg.header.frame_id = "camera_optical_frame";
    msg.width = 320;
    msg.height = 240;
    msg.distortion_model = "plumb_bob";
    msg.D.assign(5, 0.0);
    msg.K = {266.0, 0.0, 159.5, 0.0, 266.0, 119.5, 0.0, 0.0, 1.0};
    return msg;
  }
  void publishOdometry() { publishOdometry(clock.now()); }
  void publishOdometry(ros::Time stamp) {
    Odometry odometry;
    odometry.stamp = toStamp(stamp);
    odometry.odom_from_base = pose;
    odometry_pub_.publish(toRos(odometry, "odom", "base_link"));
  }

  ros::NodeHandle nh;
  TestClock clock{nh};
  Pose2 pose;

 private:
  ros::Publisher image_pub_;
  ros::Publisher info_pub_;
  ros::Publisher odometry_pub_;
  tf2_ros::StaticTransformBroadcaster tf_;
};

}  // namespace frugal_nav::test
