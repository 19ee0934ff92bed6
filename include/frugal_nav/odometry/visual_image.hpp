#pragma once

#include <opencv2/core/mat.hpp>

#include <frugal_nav/odometry/visual_params.hpp>
#include <frugal_nav/odometry/visual_status.hpp>

namespace frugal_nav {

/// The grey image of a camera image: CV_8U or CV_16U with 1, 3 or 4 channels (BGR or RGB). Empty for anything
/// else.
cv::Mat toGray(const cv::Mat& image);

/// Why a grey image (CV_8UC1) shows nothing; kNone when it may be used.
VisualReason findImageFault(const cv::Mat& gray, const VisualCheckParams& params);

/// Mean squared Laplacian of every second pixel, over the contrast: falls with blur.
double sharpness(const cv::Mat& gray);

}  // namespace frugal_nav
