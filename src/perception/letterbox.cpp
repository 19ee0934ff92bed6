#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include <frugal_nav/perception/letterbox.hpp>

namespace frugal_nav {
namespace {

cv::Size contentSize(const cv::Size& image, const cv::Size& input, Fit fit) {
  if (fit == Fit::kStretch) return input;
  const double scale = std::min(static_cast<double>(input.width) / image.width,
                                static_cast<double>(input.height) / image.height);
  const auto scaled = [scale](int length, int limit) {
    return std::clamp(static_cast<int>(std::lround(scale * length)), 1, limit);
  };
  return {scaled(image.width, input.width), scaled(image.height, input.height)};
}

}  // namespace

Letterbox::Letterbox(const cv::Size& image, const cv::Size& input, Fit fit) : input_(input) {
  const cv::Size size = contentSize(image, input, fit);
  const bool centred = fit == Fit::kLetterbox;
  content_ = cv::Rect(centred ? (input.width - size.width) / 2 : 0,
                      centred ? (input.height - size.height) / 2 : 0, size.width, size.height);
  scale_x_ = static_cast<double>(size.width) / image.width;
  scale_y_ = static_cast<double>(size.height) / image.height;
}

cv::Mat Letterbox::apply(const cv::Mat& image) const {
  cv::Mat input(input_, image.type(), cv::Scalar::all(114));
  cv::Mat content = input(content_);
  cv::resize(image, content, content_.size(), 0.0, 0.0, cv::INTER_LINEAR);
  return input;
}

cv::Rect2d Letterbox::toImage(const cv::Rect2d& box) const {
  return {(box.x - content_.x) / scale_x_, (box.y - content_.y) / scale_y_, box.width / scale_x_,
          box.height / scale_y_};
}

cv::Rect2d Letterbox::toInput(const cv::Rect2d& box) const {
  return {box.x * scale_x_ + content_.x, box.y * scale_y_ + content_.y, box.width * scale_x_,
          box.height * scale_y_};
}

}  // namespace frugal_nav
