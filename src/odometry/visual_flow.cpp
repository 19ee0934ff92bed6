#include "visual_flow.hpp"

#include "visual_corners.hpp"

#include <algorithm>

#include <opencv2/video/tracking.hpp>

namespace frugal_nav {
namespace {

constexpr int kEdge_px = 6;         // features this near the border are about to leave
constexpr double kRefill = 0.85;    // share of the wanted features below which new ones are looked for
constexpr int kRegionColumns = 12;  // cells across the dense region
constexpr float kRegionDistance_px = 4.0F;

bool isInside(const cv::Point2f& pixel, const cv::Size& size) {
  return pixel.x >= kEdge_px && pixel.y >= kEdge_px && pixel.x < static_cast<float>(size.width - kEdge_px) &&
         pixel.y < static_cast<float>(size.height - kEdge_px);
}

}  // namespace

void VisualFlow::reset() {
  last_pyramid_.clear();
  features_.clear();
}

std::vector<VisualFeature> VisualFlow::process(const cv::Mat& gray, const PixelMotion& expected,
                                               const std::optional<cv::Rect>& dense) {
  std::vector<cv::Mat> pyramid;
  const cv::Size window(params_.klt_window_px, params_.klt_window_px);
  cv::buildOpticalFlowPyramid(gray, pyramid, window, params_.klt_levels);
  if (!last_pyramid_.empty() && !features_.empty()) follow(pyramid, gray.size(), expected);
  last_pyramid_ = std::move(pyramid);

  const cv::Rect whole(kEdge_px, kEdge_px, gray.cols - 2 * kEdge_px, gray.rows - 2 * kEdge_px);
  const float apart_px = std::max(4.0F, static_cast<float>(gray.cols) / 80.0F);
  const int extra = dense ? countInside(*dense) : 0;  // the region's own do not count for the whole
  if (static_cast<double>(features_.size()) - extra < kRefill * params_.max_features)
    addCorners(gray, whole, params_.max_features + extra, apart_px);
  if (dense) {
    constexpr int kLeastSide_px = 8;
    const cv::Rect area = *dense & whole;
    if (area.width >= kLeastSide_px && area.height >= kLeastSide_px)
      addCorners(gray, area, params_.region_features, kRegionDistance_px);
  }
  return features_;
}

int VisualFlow::countInside(const cv::Rect& area) const {
  return static_cast<int>(
      std::count_if(features_.begin(), features_.end(),
                    [&](const VisualFeature& feature) { return area.contains(cv::Point(feature.pixel)); }));
}

void VisualFlow::follow(const std::vector<cv::Mat>& pyramid, const cv::Size& size,
                        const PixelMotion& expected) {
  std::vector<cv::Point2f> from;
  std::vector<cv::Point2f> to;
  for (const VisualFeature& feature : features_) {
    from.push_back(feature.pixel);
    to.push_back(expected(feature.pixel));
  }
  std::vector<cv::Point2f> back = from;
  std::vector<unsigned char> found;
  std::vector<unsigned char> found_back;
  const cv::Size window(params_.klt_window_px, params_.klt_window_px);
  const cv::TermCriteria stop(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.02);
  cv::calcOpticalFlowPyrLK(last_pyramid_, pyramid, from, to, found, cv::noArray(), window, params_.klt_levels,
                           stop, cv::OPTFLOW_USE_INITIAL_FLOW);
  // The way back starts where it should end: one level of the pyramid is enough to see it go elsewhere.
  cv::calcOpticalFlowPyrLK(pyramid, last_pyramid_, to, back, found_back, cv::noArray(), window,
                           std::min(1, params_.klt_levels), stop, cv::OPTFLOW_USE_INITIAL_FLOW);
  std::vector<VisualFeature> kept;
  for (std::size_t i = 0; i < features_.size(); ++i) {
    if (found[i] == 0 || found_back[i] == 0 || !isInside(to[i], size)) continue;
    if (cv::norm(back[i] - from[i]) > params_.forward_backward_px) continue;
    kept.push_back({features_[i].id, to[i]});
  }
  features_ = std::move(kept);
}

void VisualFlow::addCorners(const cv::Mat& gray, const cv::Rect& area, int wanted, float min_distance_px) {
  std::vector<cv::Point2f> taken;
  for (const VisualFeature& feature : features_) taken.push_back(feature.pixel);
  const bool is_region = area.width + 2 * kEdge_px < gray.cols || area.height + 2 * kEdge_px < gray.rows;
  const CornerSearch search{wanted, is_region ? kRegionColumns : params_.grid_columns, params_.fast_threshold,
                            min_distance_px};
  for (const cv::Point2f& pixel : findCorners(gray, area, taken, search))
    features_.push_back({next_id_++, pixel});
}

}  // namespace frugal_nav
