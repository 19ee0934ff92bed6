#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/view_rays.hpp>

namespace frugal_nav {

/// How the floor is told by its colour.
struct FloorMaskParams {
  int iterations = 6;
  int step_px = 2;
  double lightness_weight = 0.4;
  double same_colour = 5.0;
  double strip_height = 0.1;
  double strip_width = 0.4;
  double horizon_margin_rad = 0.02;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("iterations", iterations,
          Field{"", "rounds of k-means an image; it starts where the last image's ended", 1, 50});
    visit("step_px", step_px, Field{"px", "every n-th cell and row of the grid is clustered", 1, 16});
    visit("lightness_weight", lightness_weight,
          Field{"", "share of lightness in a colour's distance: shadows on a floor are floor", 0.0, 1.0});
    visit("same_colour", same_colour,
          Field{"", "clusters nearer than this (CIE Lab, weighted) are one: noise and light part them", 0.0,
                100.0});
    visit(
        "strip_height", strip_height,
        Field{"", "height of the strip at the bottom that shows floor, as a share of the image", 0.02, 0.5});
    visit("strip_width", strip_width, Field{"", "its width in the middle, likewise", 0.05, 1.0});
    visit("horizon_margin_rad", horizon_margin_rad,
          Field{"rad", "what looks less than this below the horizon is masked with the ceiling", 0.0, 0.3});
  }
};

/// Tells the floor by its colour: k-means with k = 2, warm-started; the floor is the cluster that holds most
/// of the strip at the bottom, as far as it is connected to it (paper 000, stage 6).
class FloorMask {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit FloorMask(const FloorMaskParams& params);

  /// The mask of an image of the grid's size (CV_8UC3, BGR): CV_8UC1, 255 floor, 0 else, also above the
  /// horizon. `likely_floor` (likewise) is where the floor is by the geometry: there the cluster is chosen
  /// and connected instead of in the strip, where something may stand. Empty: not known. All 0: nowhere, so
  /// that the last image's floor colour stays.
  cv::Mat find(const cv::Mat& small_bgr, const ViewRays& rays, const cv::Mat& likely_floor = {});

  /// Forgets the colours.
  void reset() { centres_.reset(); }

 private:
  using Colour = std::array<float, 3>;
  using Centres = std::array<Colour, 2>;  // floor first

  Centres cluster(const cv::Mat& lab, const cv::Mat& seed, const ViewRays& rays) const;
  bool areOne(const Centres& centres) const;

  FloorMaskParams params_;
  std::optional<Centres> centres_;
};

}  // namespace frugal_nav
