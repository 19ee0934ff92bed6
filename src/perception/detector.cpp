#include <frugal_nav/perception/detector.hpp>
#include <frugal_nav/perception/image_fault.hpp>

namespace frugal_nav {

bool Detector::accept(const cv::Mat& bgr) {
  const bool sound = imageFault(bgr).empty();
  ++(sound ? counts_.images : counts_.refused);
  return sound;
}

}  // namespace frugal_nav
