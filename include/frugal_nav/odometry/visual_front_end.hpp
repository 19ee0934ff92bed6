#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include <frugal_nav/odometry/visual_params.hpp>

namespace frugal_nav {

/// A feature in one image. Features of one id show the same thing.
struct VisualFeature {
  std::int64_t id = 0;
  cv::Point2f pixel;
};

/// Where a pixel of the last image is expected in the next.
using PixelMotion = std::function<cv::Point2f(const cv::Point2f&)>;

/// Follows features from image to image.
class VisualFrontEnd {
 public:
  virtual ~VisualFrontEnd() = default;
  /// The features of the next image (CV_8UC1): those that were followed, then new ones. More of them are
  /// looked for inside `dense`. All images must have one size until reset().
  virtual std::vector<VisualFeature> process(const cv::Mat& gray, const PixelMotion& expected,
                                             const std::optional<cv::Rect>& dense) = 0;
  /// Forgets all images. Ids go on: none is used twice.
  virtual void reset() = 0;
};

/// The method that the parameters name.
std::unique_ptr<VisualFrontEnd> makeVisualFrontEnd(const VisualFeatureParams& params);

}  // namespace frugal_nav
