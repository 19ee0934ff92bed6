#include "detector_support.hpp"

#include <algorithm>

#include <opencv2/imgproc.hpp>

#include <frugal_nav/perception/floor_colours.hpp>

namespace frugal_nav {
namespace {

cv::Mat toLab(const cv::Mat& bgr) {
  cv::Mat lab;
  cv::cvtColor(bgr, lab, cv::COLOR_BGR2Lab);
  return lab;
}

/// 1 2 1 along one axis of a histogram.
void blurAlong(int count, int stride, std::vector<float>& histogram) {
  const std::vector<float> before = histogram;
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    const int place = static_cast<int>(i) / stride % count;
    const auto step = static_cast<std::size_t>(stride);
    histogram[i] = 0.5F * before[i] + 0.25F * before[place > 0 ? i - step : i] +
                   0.25F * before[place + 1 < count ? i + step : i];
  }
}

}  // namespace

FloorColours::FloorColours(const FloorColourParams& params) : params_(validated(params, "floor colours")) {
  reset();
}

void FloorColours::reset() {
  const auto bins = static_cast<std::size_t>(params_.lightness_bins * params_.hue_bins * params_.hue_bins);
  floor_.assign(bins, 0.0F);
  other_.assign(bins, 0.0F);
  floor_pixels_ = other_pixels_ = 0.0;
}

std::size_t FloorColours::binOf(const cv::Vec3b& lab) const {
  // Rooms fill the middle half of the colour axes: 128 is grey.
  const auto hue = [this](int value) {
    const int bin = (value - 64) * params_.hue_bins / 128;
    return std::clamp(bin, 0, params_.hue_bins - 1);
  };
  const int lightness = lab[0] * params_.lightness_bins / 256;
  return static_cast<std::size_t>((lightness * params_.hue_bins + hue(lab[1])) * params_.hue_bins +
                                  hue(lab[2]));
}

std::vector<float> FloorColours::smoothed(const std::vector<float>& histogram) const {
  std::vector<float> result = histogram;
  blurAlong(params_.hue_bins, 1, result);
  blurAlong(params_.hue_bins, params_.hue_bins, result);
  blurAlong(params_.lightness_bins, params_.hue_bins * params_.hue_bins, result);
  return result;
}

cv::Mat FloorColours::likelihood(const cv::Mat& small_bgr) const {
  if (floor_pixels_ < params_.min_pixels) return {};
  const std::vector<float> floor = smoothed(floor_);
  const std::vector<float> other = smoothed(other_);
  const auto prior = static_cast<float>(params_.prior_weight);
  const float floor_scale = 1.0F / static_cast<float>(floor_pixels_);
  const float other_scale = other_pixels_ > 0.0 ? 1.0F / static_cast<float>(other_pixels_) : 0.0F;
  const cv::Mat lab = toLab(small_bgr);
  cv::Mat likelihood(lab.size(), CV_32FC1);
  for (int row = 0; row < lab.rows; ++row) {
    for (int column = 0; column < lab.cols; ++column) {
      const std::size_t bin = binOf(lab.at<cv::Vec3b>(row, column));
      const float is = floor[bin] * floor_scale;
      const float is_not = other[bin] * other_scale;
      likelihood.at<float>(row, column) =
          (is + static_cast<float>(params_.unseen) * prior) / (is + is_not + prior);
    }
  }
  return likelihood;
}

void FloorColours::learn(const cv::Mat& small_bgr, const cv::Mat& floor, const cv::Mat& other) {
  const auto keep = static_cast<float>(params_.keep_share);
  for (float& value : floor_) value *= keep;
  for (float& value : other_) value *= keep;
  floor_pixels_ *= params_.keep_share;
  other_pixels_ *= params_.keep_share;
  const cv::Mat lab = toLab(small_bgr);
  for (int row = 0; row < lab.rows; ++row) {
    for (int column = 0; column < lab.cols; ++column) {
      const bool is_floor = floor.at<uchar>(row, column) != 0;
      if (!is_floor && other.at<uchar>(row, column) == 0) continue;
      (is_floor ? floor_ : other_)[binOf(lab.at<cv::Vec3b>(row, column))] += 1.0F;
      (is_floor ? floor_pixels_ : other_pixels_) += 1.0;
    }
  }
}

}  // namespace frugal_nav
