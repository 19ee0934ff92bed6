#include "detector_support.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

#include <frugal_nav/perception/floor_mask.hpp>

namespace frugal_nav {
namespace {

using Colour = std::array<float, 3>;

float squaredDistance(const Colour& a, const cv::Vec3f& b) {
  float sum = 0.0F;
  for (int c = 0; c < 3; ++c) {
    const float d = a[static_cast<std::size_t>(c)] - b[c];
    sum += d * d;
  }
  return sum;
}

Colour toColour(const cv::Vec3f& v) { return {v[0], v[1], v[2]}; }

/// Where the floor is looked for: the strip at the bottom, or what is given.
cv::Mat seedOf(const cv::Size& size, const cv::Mat& likely_floor, const FloorMaskParams& params) {
  if (!likely_floor.empty()) return likely_floor;
  const int height = std::max(1, cvRound(params.strip_height * size.height));
  const int width = std::max(1, cvRound(params.strip_width * size.width));
  cv::Mat strip = cv::Mat::zeros(size, CV_8UC1);
  strip(cv::Rect((size.width - width) / 2, size.height - height, width, height)).setTo(255);
  return strip;
}

cv::Mat weightedLab(const cv::Mat& small_bgr, double lightness_weight) {
  cv::Mat scaled;
  small_bgr.convertTo(scaled, CV_32FC3, 1.0 / 255.0);
  cv::Mat lab;
  cv::cvtColor(scaled, lab, cv::COLOR_BGR2Lab);
  cv::multiply(lab, cv::Scalar(lightness_weight, 1.0, 1.0), lab);
  return lab;
}

/// What of the mask is connected to the seed.
cv::Mat connectedTo(const cv::Mat& seed, const cv::Mat& mask) {
  cv::Mat labels;
  const int count = cv::connectedComponents(mask, labels, 4, CV_32S);
  std::vector<uchar> touches(static_cast<std::size_t>(count), 0);
  for (int row = 0; row < mask.rows; ++row) {
    for (int column = 0; column < mask.cols; ++column) {
      if (seed.at<uchar>(row, column) != 0)
        touches[static_cast<std::size_t>(labels.at<int>(row, column))] = 255;
    }
  }
  touches[0] = 0;
  cv::Mat connected(mask.size(), CV_8UC1);
  for (int row = 0; row < mask.rows; ++row) {
    for (int column = 0; column < mask.cols; ++column)
      connected.at<uchar>(row, column) = touches[static_cast<std::size_t>(labels.at<int>(row, column))];
  }
  return connected;
}

}  // namespace

FloorMask::FloorMask(const FloorMaskParams& params) : params_(validated(params, "floor mask")) {}

FloorMask::Centres FloorMask::cluster(const cv::Mat& lab, const cv::Mat& seed, const ViewRays& rays) const {
  std::vector<cv::Vec3f> pixels;
  for (int column = 0; column < lab.cols; column += params_.step_px) {
    const int first = rays.firstRowBelowHorizon(column, params_.horizon_margin_rad);
    for (int row = lab.rows - 1; row >= first; row -= params_.step_px)
      pixels.push_back(lab.at<cv::Vec3f>(row, column));
  }
  const cv::Scalar seed_mean = cv::mean(lab, seed);
  Centres centres;
  if (centres_) {
    centres = *centres_;
  } else {  // the seed's colour, and the one least like it
    centres[0] = {static_cast<float>(seed_mean[0]), static_cast<float>(seed_mean[1]),
                  static_cast<float>(seed_mean[2])};
    const auto farthest =
        std::max_element(pixels.begin(), pixels.end(), [&](const cv::Vec3f& a, const cv::Vec3f& b) {
          return squaredDistance(centres[0], a) < squaredDistance(centres[0], b);
        });
    centres[1] = farthest == pixels.end() ? centres[0] : toColour(*farthest);
  }
  for (int round = 0; round < params_.iterations; ++round) {
    std::array<cv::Vec3f, 2> sums{};
    std::array<int, 2> counts{};
    for (const cv::Vec3f& pixel : pixels) {
      const std::size_t k = squaredDistance(centres[0], pixel) <= squaredDistance(centres[1], pixel) ? 0 : 1;
      sums[k] += pixel;
      ++counts[k];
    }
    for (std::size_t k = 0; k < 2; ++k) {
      if (counts[k] > 0) centres[k] = toColour(sums[k] * (1.0F / static_cast<float>(counts[k])));
    }
  }
  return centres;
}

bool FloorMask::areOne(const Centres& centres) const {
  const Colour& b = centres[1];
  return squaredDistance(centres[0], cv::Vec3f(b[0], b[1], b[2])) <
         static_cast<float>(params_.same_colour * params_.same_colour);
}

cv::Mat FloorMask::find(const cv::Mat& small_bgr, const ViewRays& rays, const cv::Mat& likely_floor) {
  const cv::Mat lab = weightedLab(small_bgr, params_.lightness_weight);
  const cv::Mat seed = seedOf(lab.size(), likely_floor, params_);
  Centres centres = cluster(lab, seed, rays);
  const bool are_one = areOne(centres);
  cv::Mat mask = cv::Mat::zeros(lab.size(), CV_8UC1);
  int votes = 0;
  for (int column = 0; column < lab.cols; ++column) {
    for (int row = rays.firstRowBelowHorizon(column, params_.horizon_margin_rad); row < lab.rows; ++row) {
      const auto& pixel = lab.at<cv::Vec3f>(row, column);
      const bool is_first = squaredDistance(centres[0], pixel) <= squaredDistance(centres[1], pixel);
      if (seed.at<uchar>(row, column) != 0) votes += is_first ? 1 : -1;
      mask.at<uchar>(row, column) = is_first || are_one ? 255 : 0;
    }
  }
  if (votes < 0 && !are_one) {  // the other cluster is the floor
    std::swap(centres[0], centres[1]);
    for (int column = 0; column < lab.cols; ++column) {
      for (int row = rays.firstRowBelowHorizon(column, params_.horizon_margin_rad); row < lab.rows; ++row)
        mask.at<uchar>(row, column) = static_cast<uchar>(255 - mask.at<uchar>(row, column));
    }
  }
  centres_ = centres;
  return cv::countNonZero(seed) > 0 ? connectedTo(seed, mask) : mask;
}

}  // namespace frugal_nav
