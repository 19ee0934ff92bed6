#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/view_rays.hpp>

namespace frugal_nav {

/// How the colours of the floor are learned.
struct FloorColourParams {
  double keep_share = 0.9;
  int lightness_bins = 8;
  int hue_bins = 24;
  double unseen = 0.25;
  double prior_weight = 0.002;
  double min_pixels = 200.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("keep_share", keep_share,
          Field{"", "share of what was learned that the next image keeps", 0.0, 1.0});
    visit("lightness_bins", lightness_bins,
          Field{"", "steps of lightness told apart: few, since shadows fall on floors", 1, 64});
    visit("hue_bins", hue_bins, Field{"", "steps of each of the two colour axes (CIE Lab)", 2, 64});
    visit("unseen", unseen, Field{"", "chance that a colour never seen is floor", 0.0, 1.0});
    visit("prior_weight", prior_weight,
          Field{"", "share of all pixels that a colour must have to be believed by half", 1e-6, 1.0});
    visit("min_pixels", min_pixels, Field{"", "pixels to have learned before anything is said", 1.0, 1e6});
  }
};

/// The colours of the floor and of all else, as histograms learned while driving: k-means knows two colours,
/// a patterned floor has more, and what stands on it may share one.
class FloorColours {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit FloorColours(const FloorColourParams& params);

  /// How likely each cell of an image (CV_8UC3, BGR) is floor by its colour, 0..1, CV_32FC1; empty while too
  /// little is known.
  cv::Mat likelihood(const cv::Mat& small_bgr) const;

  /// Learns from an image: 255 in `floor` is surely floor, 255 in `other` surely not.
  void learn(const cv::Mat& small_bgr, const cv::Mat& floor, const cv::Mat& other);
  void reset();

 private:
  std::size_t binOf(const cv::Vec3b& lab) const;
  std::vector<float> smoothed(const std::vector<float>& histogram) const;

  FloorColourParams params_;
  std::vector<float> floor_;
  std::vector<float> other_;
  double floor_pixels_ = 0.0;
  double other_pixels_ = 0.0;
};

}  // namespace frugal_nav
