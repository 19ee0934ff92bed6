#pragma once

#include <vector>

#include <opencv2/features2d.hpp>

#include <frugal_nav/odometry/visual_front_end.hpp>

namespace frugal_nav {

/// ORB features compared by their descriptors with those of the last images: ratio test, both ways.
class VisualMatching : public VisualFrontEnd {
 public:
  explicit VisualMatching(const VisualFeatureParams& params);
  std::vector<VisualFeature> process(const cv::Mat& gray, const PixelMotion& expected,
                                     const std::optional<cv::Rect>& dense) override;
  void reset() override;

 private:
  /// A feature of the last images, with where it is expected by now.
  struct Remembered {
    std::int64_t id = 0;
    cv::Point2f pixel;
    int age = 0;  ///< images since it was seen
  };

  std::vector<int> match(const std::vector<cv::KeyPoint>& keypoints, const cv::Mat& descriptors,
                         float radius_px) const;

  VisualFeatureParams params_;
  cv::Ptr<cv::ORB> orb_;
  std::vector<Remembered> memory_;
  cv::Mat memory_descriptors_;
  std::int64_t next_id_ = 0;
};

}  // namespace frugal_nav
