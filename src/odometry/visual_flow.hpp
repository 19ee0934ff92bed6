#pragma once

#include <vector>

#include <frugal_nav/odometry/visual_front_end.hpp>

namespace frugal_nav {

/// Corners followed by pyramidal Lucas-Kanade optical flow, there and back.
class VisualFlow : public VisualFrontEnd {
 public:
  explicit VisualFlow(const VisualFeatureParams& params) : params_(params) {}
  std::vector<VisualFeature> process(const cv::Mat& gray, const PixelMotion& expected,
                                     const std::optional<cv::Rect>& dense) override;
  void reset() override;

 private:
  void follow(const std::vector<cv::Mat>& pyramid, const cv::Size& size, const PixelMotion& expected);
  int countInside(const cv::Rect& area) const;
  void addCorners(const cv::Mat& gray, const cv::Rect& area, int wanted, float min_distance_px);

  VisualFeatureParams params_;
  std::vector<cv::Mat> last_pyramid_;
  std::vector<VisualFeature> features_;
  std::int64_t next_id_ = 0;
};

}  // namespace frugal_nav
