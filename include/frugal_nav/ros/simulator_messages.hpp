#pragma once

#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>

#include <frugal_nav/Contact.h>
#include <frugal_nav/WheelTicks.h>
#include <frugal_nav/sim/simulator.hpp>

namespace frugal_nav {

// The simulator's data as messages; frames as in the URDF.

WheelTicks toRos(const sim::WheelTicks& ticks);
/// The covariances follow from the profile's noise densities; there is no orientation (REP-145).
sensor_msgs::Imu toRos(const sim::ImuSample& sample, const sim::ImuParams& profile);
sensor_msgs::LaserScan toRos(const LaserScan& scan, Duration period);
sensor_msgs::ImagePtr toRos(const sim::CameraImage& image);
sensor_msgs::ImagePtr toRos(const sim::DepthImage& image);
sensor_msgs::CameraInfo cameraInfo(const sim::Camera& camera, Stamp stamp);
/// Pose in "world", velocity in base_link.
nav_msgs::Odometry toRos(const sim::GroundTruth& truth);
Contact toRos(const sim::Contact& contact);

}  // namespace frugal_nav
