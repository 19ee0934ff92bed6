#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace frugal_nav {

/// How an image fills a network's input.
enum class Fit {
  kLetterbox,  ///< aspect kept, padded evenly on both sides (YOLOv5, v7, v8)
  kCorner,     ///< aspect kept, padded right and below (YOLOX, YuNet)
  kStretch     ///< resized in both directions (Darknet)
};

/// The mapping between an image and a network's input, and back: exact, because it uses the whole number of
/// pixels the image was resized to instead of the wanted scale.
class Letterbox {
 public:
  /// Both sizes must be positive.
  Letterbox(const cv::Size& image, const cv::Size& input, Fit fit);

  /// The network's input; what the image leaves free has grey level 114.
  cv::Mat apply(const cv::Mat& image) const;
  /// A box of the network's input, in pixels of the image.
  cv::Rect2d toImage(const cv::Rect2d& box) const;
  /// A box of the image, in pixels of the network's input.
  cv::Rect2d toInput(const cv::Rect2d& box) const;

 private:
  cv::Size input_;
  cv::Rect content_;  // where the image lies in the input
  double scale_x_;
  double scale_y_;
};

}  // namespace frugal_nav
