#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include <frugal_nav/common/params.hpp>

namespace frugal_nav {

/// How markers are looked for.
struct MarkerDetectorParams {
  std::string dictionary = "DICT_4X4_50";
  int threshold_window_min_px = 5;
  int threshold_window_max_px = 21;
  int threshold_window_step_px = 16;
  double min_side_px = 10.0;
  double error_correction_share = 0.6;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit(
        "dictionary", dictionary,
        atStart(Field{
            "", "OpenCV's name of the set the markers are from; marker_localization: empty for the map's"}));
    visit(
        "threshold_window_min_px", threshold_window_min_px,
        Field{"px", "smallest window of the adaptive threshold: for thin borders and small markers", 3, 99});
    visit("threshold_window_max_px", threshold_window_max_px,
          Field{"px", "largest window: for large markers and soft light", 3, 199});
    visit("threshold_window_step_px", threshold_window_step_px,
          Field{"px", "from one window to the next: each of them costs a pass over the image", 2, 100});
    visit("min_side_px", min_side_px,
          Field{"px", "markers with shorter sides are not looked for: their corners are too rough", 6.0,
                200.0});
    visit("error_correction_share", error_correction_share,
          Field{"", "share of the dictionary's error correction to use; more finds markers where none are",
                0.0, 1.0});
  }
  std::string check() const {
    return threshold_window_min_px <= threshold_window_max_px
               ? ""
               : "threshold_window_min_px must not exceed threshold_window_max_px";
  }
};

/// A marker in an image: upper left, upper right, lower right, lower left of the print, however it is turned.
struct MarkerCorners {
  int id = -1;
  std::array<Eigen::Vector2d, 4> pixels;  ///< the centre of the image's first pixel is (0, 0)
  bool is_clipped = false;                ///< the white around it is overexposed: it spreads over the black
  bool has_edges = true;                  ///< or its corners are those of the search, good to a pixel or two
};

/// What an image shows.
struct MarkerFindings {
  std::vector<MarkerCorners> markers;  ///< by id; an id twice in the image is here twice
  std::vector<int> unlisted_ids;       ///< seen, but not on the whitelist
  std::string fault;                   ///< why the image cannot be searched; empty when it was
};

/// Finds square markers and their corners to a fraction of a pixel.
class MarkerDetector {
 public:
  /// Only ids of the whitelist are given out; all of them when it is empty. Throws ConfigError on parameters
  /// out of range, an unknown dictionary, and an id the dictionary does not have.
  explicit MarkerDetector(const MarkerDetectorParams& params, const std::vector<int>& whitelist = {});
  ~MarkerDetector();
  MarkerDetector(MarkerDetector&&) noexcept;
  MarkerDetector& operator=(MarkerDetector&&) noexcept;

  /// Searches an 8-bit image, grey or BGR, in sRGB as cameras give it.
  MarkerFindings detect(const cv::Mat& image) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace frugal_nav
