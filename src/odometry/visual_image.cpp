#include <opencv2/imgproc.hpp>

#include <frugal_nav/odometry/visual_image.hpp>

namespace frugal_nav {

cv::Mat toGray(const cv::Mat& image) {
  if (image.empty() || image.dims != 2 || (image.depth() != CV_8U && image.depth() != CV_16U)) return {};
  cv::Mat gray;
  // RGB read as BGR swaps the weights of red and blue: the same in every image, so that nothing is lost.
  if (image.channels() == 1) {
    gray = image;
  } else if (image.channels() == 3) {
    cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  } else if (image.channels() == 4) {
    cv::cvtColor(image, gray, cv::COLOR_BGRA2GRAY);
  } else {
    return {};
  }
  if (gray.depth() == CV_16U) gray.convertTo(gray, CV_8U, 1.0 / 257.0);
  return gray;
}

VisualReason findImageFault(const cv::Mat& gray, const VisualCheckParams& params) {
  cv::Mat small;
  cv::resize(gray, small, cv::Size(), 0.25, 0.25, cv::INTER_NEAREST);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(small, mean, deviation);
  if (mean[0] < params.dark_level) return VisualReason::kDark;
  if (mean[0] > params.bright_level) return VisualReason::kSaturated;
  if (deviation[0] < params.min_contrast) return VisualReason::kNoContrast;
  return VisualReason::kNone;
}

double sharpness(const cv::Mat& gray) {
  cv::Mat small;
  cv::resize(gray, small, cv::Size(), 0.5, 0.5, cv::INTER_LINEAR);
  cv::Mat laplacian;
  cv::Laplacian(small, laplacian, CV_16S);
  cv::Scalar mean;
  cv::Scalar contrast;
  cv::meanStdDev(small, mean, contrast);
  cv::Scalar edges;
  cv::meanStdDev(laplacian, mean, edges);
  constexpr double kLeastVariance = 1.0;  // of an image of one colour
  return edges[0] * edges[0] / (contrast[0] * contrast[0] + kLeastVariance);
}

}  // namespace frugal_nav
