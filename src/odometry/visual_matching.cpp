#include "visual_matching.hpp"

#include <algorithm>

#include <opencv2/core/hal/hal.hpp>

namespace frugal_nav {
namespace {

constexpr int kMemory = 3;  // images a feature is remembered for when it is not seen
constexpr float kSamePlace_px = 4.0F;
constexpr int kMaxDistance = 64;  // bits of 256: a quarter; unrelated descriptors differ in half

/// A candidate for a match.
struct Candidate {
  int index = -1;
  int distance = 0;
  cv::Point2f pixel;
};

/// The nearest candidate, when no other place looks nearly as much like it (Lowe's ratio test). Another
/// feature at the same place (a corner seen on two levels of the pyramid) is no rival. -1 for none.
int distinctNearest(const std::vector<Candidate>& candidates, double ratio) {
  const auto best = std::min_element(candidates.begin(), candidates.end(),
                                     [](const auto& a, const auto& b) { return a.distance < b.distance; });
  if (best == candidates.end() || best->distance > kMaxDistance) return -1;
  for (const Candidate& other : candidates) {
    const cv::Point2f off = other.pixel - best->pixel;
    const bool is_rival = off.dot(off) > kSamePlace_px * kSamePlace_px;
    if (is_rival && best->distance > ratio * other.distance) return -1;
  }
  return best->index;
}

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
  std::vector<std::vector<Candidate>> forward(keypoints.size());
  std::vector<std::vector<Candidate>> backward(memory_.size());
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    for (std::size_t j = 0; j < memory_.size(); ++j) {
      const cv::Point2f off = memory_[j].pixel - keypoints[i].pt;
      if (off.dot(off) > radius_px * radius_px) continue;
      const int distance =
          cv::hal::normHamming(descriptors.ptr(static_cast<int>(i)),
                               memory_descriptors_.ptr(static_cast<int>(j)), descriptors.cols);
      forward[i].push_back({static_cast<int>(j), distance, memory_[j].pixel});
      backward[j].push_back({static_cast<int>(i), distance, keypoints[i].pt});
    }
  }
  std::vector<int> matches(keypoints.size(), -1);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const int nearest = distinctNearest(forward[i], params_.ratio);
    if (nearest < 0) continue;
    if (distinctNearest(backward[static_cast<std::size_t>(nearest)], 1.0) == static_cast<int>(i))
      matches[i] = nearest;
  }
  return matches;
}

}  // namespace frugal_nav
