#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/pinhole.hpp>

namespace frugal_nav {

/// What is wrong with an image that is to be CV_8UC3, BGR; empty when it can be used.
std::string imageFault(const cv::Mat& bgr);

/// Whether a sound image shows anything: what is wrong with a black or a saturated one; empty otherwise.
std::string exposureFault(const cv::Mat& bgr);

/// What keeps an image, its camera and the pose it was taken from from being measured in; empty when they can
/// be used. The image may be a resized one of the camera's, not a part of it.
std::string viewFault(const cv::Mat& bgr, const Pinhole& camera, const Pose2& odom_from_base);

}  // namespace frugal_nav
