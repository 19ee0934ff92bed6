#include <algorithm>
#include <cmath>
#include <limits>

#include <frugal_nav/perception/depth_correction.hpp>

namespace frugal_nav {
namespace {

constexpr float kLeast_pm = 0.02F;  // beyond 50 m all depths are one
constexpr float kMost_pm = 8.0F;

/// Sums of weight and weighted value over image and logarithm of depth.
class BilateralGrid {
 public:
  BilateralGrid(const cv::Size& size, const DepthCorrectionParams& params)
      : cell_(static_cast<float>(std::max(1.0, params.cell_share * size.width))),
        step_(static_cast<float>(params.depth_step)),
        width_(static_cast<int>(static_cast<float>(size.width) / cell_) + 3),
        height_(static_cast<int>(static_cast<float>(size.height) / cell_) + 3),
        layers_(static_cast<int>(std::log(kMost_pm / kLeast_pm) / step_) + 3),
        weight_(static_cast<std::size_t>(width_ * height_ * layers_), 0.0F),
        value_(weight_.size(), 0.0F) {}

  void add(float x, float y, float inverse_depth, float weight, float value) {
    visit(x, y, inverse_depth, [&](std::size_t i, float share) {
      weight_[i] += share * weight;
      value_[i] += share * weight * value;
    });
  }

  void blur() {
    for (const auto& [count, stride] :
         {std::pair{width_, 1}, {height_, width_}, {layers_, width_ * height_}}) {
      blurAlong(weight_, count, stride);
      blurAlong(value_, count, stride);
    }
  }

  /// Weight and weighted value at a place.
  std::pair<float, float> at(float x, float y, float inverse_depth) const {
    std::pair<float, float> sums{0.0F, 0.0F};
    visit(x, y, inverse_depth, [&](std::size_t i, float share) {
      sums.first += share * weight_[i];
      sums.second += share * value_[i];
    });
    return sums;
  }

 private:
  template <class Visit>
  void visit(float x, float y, float inverse_depth, const Visit& cell) const {
    const float gx = x / cell_ + 0.5F;
    const float gy = y / cell_ + 0.5F;
    const float gz = std::log(std::clamp(inverse_depth, kLeast_pm, kMost_pm) / kLeast_pm) / step_;
    const int ix = static_cast<int>(gx);
    const int iy = static_cast<int>(gy);
    const int iz = static_cast<int>(gz);
    const float fx = gx - static_cast<float>(ix);
    const float fy = gy - static_cast<float>(iy);
    const float fz = gz - static_cast<float>(iz);
    for (int k = 0; k < 8; ++k) {
      const int dx = k & 1;
      const int dy = (k >> 1) & 1;
      const int dz = k >> 2;
      const float share =
          (dx != 0 ? fx : 1.0F - fx) * (dy != 0 ? fy : 1.0F - fy) * (dz != 0 ? fz : 1.0F - fz);
      cell(static_cast<std::size_t>(((iz + dz) * height_ + iy + dy) * width_ + ix + dx), share);
    }
  }

  /// 1 2 1 along one axis, unnormalised at the middle so that a lone anchor keeps its weight.
  void blurAlong(std::vector<float>& values, int count, int stride) {
    const std::vector<float> before = values;
    const int total = static_cast<int>(values.size());
    for (int i = 0; i < total; ++i) {
      const int place = (i / stride) % count;
      float sum = before[static_cast<std::size_t>(i)];
      if (place > 0) sum += 0.5F * before[static_cast<std::size_t>(i - stride)];
      if (place + 1 < count) sum += 0.5F * before[static_cast<std::size_t>(i + stride)];
      values[static_cast<std::size_t>(i)] = sum;
    }
  }

  float cell_;
  float step_;
  int width_;
  int height_;
  int layers_;
  std::vector<float> weight_;
  std::vector<float> value_;
};

/// The cell near an anchor's whose fitted depth is most like the anchor's: at an edge the anchor's own cell
/// may show what lies behind.
cv::Point mostAlike(const cv::Mat& inverse_depth_pm, const cv::Point& cell, double anchor_pm) {
  constexpr int kReach = 2;
  cv::Point best = cell;
  double least = std::numeric_limits<double>::infinity();
  for (int row = std::max(0, cell.y - kReach); row <= std::min(inverse_depth_pm.rows - 1, cell.y + kReach);
       ++row) {
    for (int column = std::max(0, cell.x - kReach);
         column <= std::min(inverse_depth_pm.cols - 1, cell.x + kReach); ++column) {
      const auto fitted = static_cast<double>(std::max(inverse_depth_pm.at<float>(row, column), kLeast_pm));
      const double off = std::abs(std::log(anchor_pm / fitted));
      if (off >= least) continue;
      least = off;
      best = {column, row};
    }
  }
  return best;
}

}  // namespace

cv::Mat correctDepth(const cv::Mat& inverse_depth_pm, const std::vector<DepthAnchor>& anchors,
                     const DepthCorrectionParams& params, cv::Mat* weight) {
  BilateralGrid grid(inverse_depth_pm.size(), params);
  const double prior = 1.0 / (params.network_sigma * params.network_sigma);
  for (const DepthAnchor& anchor : anchors) {
    const cv::Point own(cvRound(anchor.cell.x), cvRound(anchor.cell.y));
    if (!cv::Rect(cv::Point(), inverse_depth_pm.size()).contains(own)) continue;
    float fitted = inverse_depth_pm.at<float>(own);
    double ratio = std::log(anchor.inverse_depth_pm / std::max(fitted, kLeast_pm));
    double gate = anchor.gate;
    if (ratio > gate && ratio < anchor.unseen_gate) {
      fitted = inverse_depth_pm.at<float>(mostAlike(inverse_depth_pm, own, anchor.inverse_depth_pm));
      ratio = std::log(anchor.inverse_depth_pm / std::max(fitted, kLeast_pm));
      gate = ratio > gate ? anchor.unseen_gate : gate;
    }
    if (!(std::abs(ratio) < gate)) continue;
    const double variance = anchor.relative_sigma * anchor.relative_sigma + 1e-4;
    const double trust = 1.0 / (1.0 + std::pow(ratio / std::max(params.doubt, 0.5 * gate), 2));
    // Weights are in units of the prior's: one for an anchor no better than the network.
    grid.add(anchor.cell.x, anchor.cell.y, fitted, static_cast<float>(trust / variance / prior),
             static_cast<float>(ratio));
  }
  for (int i = 0; i < params.blur_rounds; ++i) grid.blur();
  cv::Mat corrected(inverse_depth_pm.size(), CV_32FC1);
  if (weight != nullptr) weight->create(inverse_depth_pm.size(), CV_32FC1);
  for (int row = 0; row < corrected.rows; ++row) {
    for (int column = 0; column < corrected.cols; ++column) {
      const float fitted = inverse_depth_pm.at<float>(row, column);
      const auto [sum, value] = grid.at(static_cast<float>(column), static_cast<float>(row), fitted);
      corrected.at<float>(row, column) = fitted * std::exp(value / (sum + 1.0F));
      if (weight != nullptr) weight->at<float>(row, column) = sum / (sum + 1.0F);
    }
  }
  return corrected;
}

}  // namespace frugal_nav
