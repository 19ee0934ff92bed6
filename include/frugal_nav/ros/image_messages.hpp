#pragma once

#include <string>

#include <boost/shared_ptr.hpp>
#include <opencv2/core/mat.hpp>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <frugal_nav/common/pinhole.hpp>

namespace frugal_nav {

/// An image message as a picture.
struct DecodedImage {
  cv::Mat bgr;                          ///< CV_8UC3; may be the message's own memory: not to be written to
  boost::shared_ptr<const void> owner;  ///< keeps that memory
  std::string fault;                    ///< why there is no picture; empty when there is
};

/// Decodes mono8, mono16, rgb8, bgr8, rgba8, bgra8, their 16-bit kin, bayer_* and yuv422; bgr8 without a
/// copy. Anything else (depth, floats, sizes that contradict each other) is a fault that says what came.
DecodedImage decode(const sensor_msgs::ImageConstPtr& msg);

/// What a camera_info tells of the images beside it.
struct Calibration {
  Pinhole camera;
  std::string fault;  ///< why the camera is not calibrated and what to do; empty when it is
};

/// Binning and a region of interest are taken in; lenses other than plumb_bob are a fault.
Calibration fromRos(const sensor_msgs::CameraInfo& msg);

/// The calibration of an image of that size: the same or a resized one. One of another shape is a fault.
Calibration fitTo(const Calibration& calibration, int width_px, int height_px);

}  // namespace frugal_nav
