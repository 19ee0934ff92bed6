#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/detector.hpp>

namespace frugal_nav {

/// How far-away heads are looked at again.
struct CloserLookParams {
  bool enabled = true;
  double share = 0.65;
  double max_height_share = 0.09;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("enabled", enabled,
          Field{"",
                "look again at parts of the image, enlarged: at two while there is no goal, at one around a "
                "goal far away; each costs the detector's time once more"});
    visit(
        "share", share,
        Field{"", "width and height of a part over those of the image; two must cover its width", 0.5, 1.0});
    visit(
        "max_height_share", max_height_share,
        Field{"", "a goal whose box should be lower than this, as a share of the image's height, is far away",
              0.0, 1.0});
  }
};

/// Second looks at parts of an image, which a detector with an input of fixed size sees enlarged: a head six
/// metres away is a dozen pixels high there (slicing, Akyon et al. 2022).
class CloserLook {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit CloserLook(const CloserLookParams& params);
  const CloserLookParams& params() const { return params_; }

  /// Two parts side by side over the image's width, with `row_px` at half their height as far as they fit.
  std::vector<cv::Rect> across(const cv::Size& image, double row_px) const;
  /// The part with `center_px` in its middle as far as it fits.
  cv::Rect around(const cv::Size& image, const cv::Point2d& center_px) const;

  /// Adds what a detector sees in the parts of an image (CV_8UC3) to what it saw in the whole, best first; of
  /// several boxes of one thing the best stays. Boxes that a part's edge cuts within the image are left out,
  /// and so are pieces of larger things.
  static std::vector<Detection> add(std::vector<Detection> whole, const cv::Mat& bgr,
                                    const std::vector<cv::Rect>& parts, Detector& detector);

 private:
  CloserLookParams params_;
};

}  // namespace frugal_nav
