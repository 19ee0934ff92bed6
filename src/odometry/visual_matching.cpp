#include "visual_matching.hpp"

#include <algorithm>

#include <opencv2/core/hal/hal.hpp>

namespace frugal_nav {
namespace {

constexpr int kMemory = 3;        // images a feature is remembered for when it is not seen
constexpr int kMaxDistance = 64;  // bits of 256: a quarter; unrelated descriptors differ in half

/// The two nearest of a row of descriptors.
struct Nearest {
  int index = -1;
  int best = 257;
  int second = 257;

  void offer(int candidate, int distance) {
    if (distance < best) {
      second = best;
      best = distance;
      index = candidate;
    } else {
      second = std::min(second, distance);
    }
  }
};

}  // namespace

VisualMatching::VisualMatching(const VisualFeatureParams& params)
    : params_(params),
      orb_(cv::ORB::create(params.orb_features, 1.2F, 4, 15, 0, 2, cv::ORB::HARRIS_SCORE, 31,
                           params.fast_threshold)) {}

void VisualMatching::reset() {
  memory_.clear();
  memory_descriptors_.release();
}

std::vector<VisualFeature> VisualMatching::process(const cv::Mat& gray, const PixelMotion& expected,
                                                   const std::optional<cv::Rect>& dense) {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  orb_->detectAndCompute(gray, cv::noArray(), keypoints, descriptors);
  if (dense && !(*dense & cv::Rect({0, 0}, gray.size())).empty()) {
    // ORB spreads its features by strength alone: a second search gives the region its own.
    cv::Mat mask(gray.size(), CV_8U, cv::Scalar(0));
    mask(*dense & cv::Rect({0, 0}, gray.size())).setTo(255);
    std::vector<cv::KeyPoint> more;
    cv::Mat more_descriptors;
    orb_->setMaxFeatures(std::max(1, params_.region_features));
    orb_->detectAndCompute(gray, mask, more, more_descriptors);
    orb_->setMaxFeatures(params_.orb_features);
    keypoints.erase(std::remove_if(keypoints.begin(), keypoints.end(),
                                   [&](const cv::KeyPoint& k) { return dense->contains(cv::Point(k.pt)); }),
                    keypoints.end());
    orb_->compute(gray, keypoints, descriptors);
    keypoints.insert(keypoints.end(), more.begin(), more.end());
    if (descriptors.empty()) {
      descriptors = more_descriptors;
    } else if (!more_descriptors.empty()) {
      cv::vconcat(descriptors, more_descriptors, descriptors);
    }
  }

  for (Remembered& feature : memory_) feature.pixel = expected(feature.pixel);
  const std::vector<int> matches =
      match(keypoints, descriptors, static_cast<float>(params_.search_radius * gray.cols));
  std::vector<VisualFeature> features;
  std::vector<Remembered> memory;
  cv::Mat memory_descriptors = descriptors.clone();
  std::vector<char> is_seen(memory_.size(), 0);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    if (matches[i] >= 0) is_seen[static_cast<std::size_t>(matches[i])] = 1;
    const std::int64_t id = matches[i] >= 0 ? memory_[static_cast<std::size_t>(matches[i])].id : next_id_++;
    features.push_back({id, keypoints[i].pt});
    memory.push_back({id, keypoints[i].pt, 0});
  }
  for (std::size_t i = 0; i < memory_.size(); ++i) {
    if (is_seen[i] != 0 || memory_[i].age + 1 >= kMemory) continue;
    memory.push_back({memory_[i].id, memory_[i].pixel, memory_[i].age + 1});
    memory_descriptors.push_back(memory_descriptors_.row(static_cast<int>(i)));
  }
  memory_ = std::move(memory);
  memory_descriptors_ = memory_descriptors;
  return features;
}

std::vector<int> VisualMatching::match(const std::vector<cv::KeyPoint>& keypoints, const cv::Mat& descriptors,
                                       float radius_px) const {
  std::vector<Nearest> forward(keypoints.size());
  std::vector<Nearest> backward(memory_.size());
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    for (std::size_t j = 0; j < memory_.size(); ++j) {
      const cv::Point2f off = memory_[j].pixel - keypoints[i].pt;
      if (off.x * off.x + off.y * off.y > radius_px * radius_px) continue;
      const int distance =
          cv::hal::normHamming(descriptors.ptr(static_cast<int>(i)),
                               memory_descriptors_.ptr(static_cast<int>(j)), descriptors.cols);
      forward[i].offer(static_cast<int>(j), distance);
      backward[j].offer(static_cast<int>(i), distance);
    }
  }
  std::vector<int> matches(keypoints.size(), -1);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const Nearest& near = forward[i];
    if (near.index < 0 || near.best > kMaxDistance || near.best >= params_.ratio * near.second) continue;
    if (backward[static_cast<std::size_t>(near.index)].index == static_cast<int>(i)) matches[i] = near.index;
  }
  return matches;
}

}  // namespace frugal_nav
