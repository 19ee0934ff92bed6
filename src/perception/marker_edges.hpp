#pragma once

// Corners of a marker to a fraction of a pixel, shared by the detector and its tests.

#include <array>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace frugal_nav::marker_detail {

/// The light that an 8-bit grey image in sRGB stands for, 0 to 1 (CV_32FC1). A pixel half covered by white is
/// bright in sRGB: edges found there lie in the dark side.
cv::Mat linearLight(const cv::Mat& grey);

/// Moves corners, right to a pixel or two, to where straight lines through the marker's four edges meet. Blur
/// rounds a corner and pulls it inward, but leaves an edge where it is. False, with the corners as they were,
/// when the edges are not found. `cells` are those along a side of the black square.
bool fitEdges(const cv::Mat& light, int cells, std::array<Eigen::Vector2d, 4>& corners);

/// Whether most of the white around a marker is overexposed.
bool isClipped(const cv::Mat& light, int cells, const std::array<Eigen::Vector2d, 4>& corners);

}  // namespace frugal_nav::marker_detail
