#include <cmath>
#include <cstdlib>

#include <opencv2/core.hpp>
#include <opencv2/core/check.hpp>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/perception/image_fault.hpp>

namespace frugal_nav {
namespace {

std::string sizeText(int width_px, int height_px) {
  return std::to_string(width_px) + "x" + std::to_string(height_px);
}

}  // namespace

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

std::string viewFault(const cv::Mat& bgr, const Pinhole& camera, const Pose2& odom_from_base) {
  std::string fault = imageFault(bgr);
  if (fault.empty()) fault = exposureFault(bgr);
  if (fault.empty()) fault = camera.fault();
  if (!fault.empty()) return fault;
  if (!odom_from_base.isFinite()) return "the odometry is not finite";
  // A resized image keeps its shape, to a row of rounding; a cropped one has another principal point.
  const int rows =
      static_cast<int>(std::lround(static_cast<double>(bgr.cols) * camera.height_px / camera.width_px));
  if (std::abs(rows - bgr.rows) > 1) {
    return "the image is " + sizeText(bgr.cols, bgr.rows) + ", but its camera is calibrated for " +
           sizeText(camera.width_px, camera.height_px);
  }
  return {};
}

}  // namespace frugal_nav
