#pragma once

#include <opencv2/core/mat.hpp>

#include <frugal_nav/perception/depth_gap.hpp>

namespace frugal_nav {

/// What was understood of an image (CV_8UC3), drawn over it for people: floor green, the line on which things
/// stand, the profile as bars at the bottom (red near, green open), the gap between two lines with its width,
/// the nearest obstacle boxed with its distance, how sure and by what; or the fault.
cv::Mat drawDepthFrame(const cv::Mat& bgr, const DepthFrame& frame);

}  // namespace frugal_nav
