#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// A place of the grid whose metric depth is known.
struct DepthAnchor {
  cv::Point2f cell;               ///< in the grid
  double inverse_depth_pm = 0.0;  ///< [1/m]
  double relative_sigma = 0.0;    ///< standard deviation of the depth as a share of it
  double gate = 0.6;  ///< a fitted depth off by more (logarithm) is another surface's, or the anchor is wrong
  double unseen_gate = 0.0;  ///< the same for one nearer than all fitted depths about it: not fitted at all
};

/// How far a known depth mends the depths about it.
struct DepthCorrectionParams {
  double cell_share = 0.05;
  double depth_step = 0.15;
  int blur_rounds = 2;
  double network_sigma = 0.12;
  double doubt = 0.25;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("cell_share", cell_share,
          Field{"", "reach along the image, as a share of its width, before blurring", 0.01, 0.5});
    visit("depth_step", depth_step,
          Field{"", "reach across depths (logarithm): edges keep what lies behind them apart", 0.02, 1.0});
    visit("blur_rounds", blur_rounds, Field{"", "how often the reach is widened by a cell", 0, 10});
    visit("network_sigma", network_sigma,
          Field{"", "local error of the fitted depth: how easily it is mended", 0.001, 1.0});
    visit(
        "doubt", doubt,
        Field{"", "a depth off by more (logarithm) counts less and less: at an edge it is another surface's",
              0.01, 10.0});
  }
};

/// Mends a fitted inverse depth where depths are known: the logarithm of the ratio, spread over places near
/// in the image and in depth by a bilateral grid (Chen, Paris, Durand, SIGGRAPH 2007), shrunk to zero where
/// nothing is known. `inverse_depth_pm` is CV_32FC1 [1/m]; the result likewise. `weight`, when given, tells
/// how much each place rests on anchors, 0..1.
cv::Mat correctDepth(const cv::Mat& inverse_depth_pm, const std::vector<DepthAnchor>& anchors,
                     const DepthCorrectionParams& params, cv::Mat* weight = nullptr);

}  // namespace frugal_nav
