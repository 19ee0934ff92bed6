#include <opencv2/core.hpp>
#include <opencv2/core/check.hpp>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/perception/detector.hpp>

namespace frugal_nav {

std::string imageFault(const cv::Mat& bgr) {
  if (bgr.empty()) return "the image is empty";
  if (bgr.dims != 2 || bgr.type() != CV_8UC3) {
    return "the image has type " + cv::typeToString(bgr.type()) + " instead of CV_8UC3 (BGR)";
  }
  return {};
}

std::string exposureFault(const cv::Mat& bgr) {
  constexpr double kBlack = 4.0;        // below the noise of a covered lens
  constexpr double kSaturated = 251.0;  // nearly every channel at its end
  constexpr int kSample = 32;
  cv::Mat small;
  cv::resize(bgr, small, cv::Size(kSample, kSample), 0.0, 0.0, cv::INTER_AREA);
  double darkest = 0.0;
  double brightest = 0.0;
  cv::minMaxLoc(small.reshape(1), &darkest, &brightest);
  if (brightest < kBlack) return "the image is black";
  if (darkest > kSaturated) return "the image is saturated";
  return {};
}

bool Detector::accept(const cv::Mat& bgr) {
  const bool sound = imageFault(bgr).empty();
  ++(sound ? counts_.images : counts_.refused);
  return sound;
}

}  // namespace frugal_nav
