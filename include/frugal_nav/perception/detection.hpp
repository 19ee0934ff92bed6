#pragma once

#include <string>

#include <opencv2/core/types.hpp>

namespace frugal_nav {

/// One thing a detector found.
struct Detection {
  int class_id = 0;
  std::string label;
  double score = 0.0;  ///< 0..1
  cv::Rect2d box;      ///< in pixels of the image, from its upper left edge: the first pixel spans 0..1
};

}  // namespace frugal_nav
