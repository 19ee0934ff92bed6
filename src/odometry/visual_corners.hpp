#pragma once

#include <vector>

#include <opencv2/core.hpp>

namespace frugal_nav {

/// What corners to look for.
struct CornerSearch {
  int wanted = 300;         ///< with those already there
  int grid_columns = 16;    ///< cells across the area, which share them
  int fast_threshold = 14;  ///< grey levels
  float min_distance_px = 8.0F;
};

/// New corners inside `area`: FAST's, the best of each cell by Shi and Tomasi's measure, apart from each
/// other and from `taken`.
std::vector<cv::Point2f> findCorners(const cv::Mat& gray, const cv::Rect& area,
                                     const std::vector<cv::Point2f>& taken, const CornerSearch& search);

}  // namespace frugal_nav
