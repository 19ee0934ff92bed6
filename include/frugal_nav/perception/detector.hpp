#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/perception/detection.hpp>

namespace frugal_nav {

/// What a detector has met.
struct DetectorCounts {
  std::uint64_t images = 0;      ///< looked at
  std::uint64_t refused = 0;     ///< images that cannot be used
  std::uint64_t not_finite = 0;  ///< boxes the network gave that were no numbers
};

/// Finds things in images.
class Detector {
 public:
  virtual ~Detector() = default;

  /// What is seen in an image (CV_8UC3, BGR), the best score first, boxes within the image. Nothing for an
  /// image with an imageFault, which is counted.
  virtual std::vector<Detection> detect(const cv::Mat& bgr) = 0;

  const DetectorCounts& counts() const { return counts_; }

 protected:
  /// Counts the image; whether it can be used.
  bool accept(const cv::Mat& bgr);

  DetectorCounts counts_;
};

}  // namespace frugal_nav
