#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <frugal_nav/perception/closer_look.hpp>
#include <frugal_nav/perception/yolo_decoders.hpp>

namespace frugal_nav {
namespace {

// Boxes of one class that share more are the same thing, though one look may see a head larger than the
// other.
constexpr double kSameThing = 0.35;
// A box that ends this close to a part's edge is cut off by it [px of the image].
constexpr double kEdge_px = 2.0;

/// Whether a box ends at an edge of the part that is not one of the image.
bool isCut(const cv::Rect2d& box, const cv::Rect& part, const cv::Size& image) {
  return (part.x > 0 && box.x < part.x + kEdge_px) || (part.y > 0 && box.y < part.y + kEdge_px) ||
         (part.br().x < image.width && box.br().x > part.br().x - kEdge_px) ||
         (part.br().y < image.height && box.br().y > part.br().y - kEdge_px);
}

}  // namespace

CloserLook::CloserLook(const CloserLookParams& params) : params_(params) { validate(params, "closer look"); }

std::vector<cv::Rect> CloserLook::across(const cv::Size& image, double row_px) const {
  const cv::Rect left = around(image, {0.0, row_px});
  const cv::Rect right = around(image, {static_cast<double>(image.width), row_px});
  return {left, right};
}

cv::Rect CloserLook::around(const cv::Size& image, const cv::Point2d& center_px) const {
  const auto place = [this](double center, int length, int& begin, int& size) {
    size = std::max(1, static_cast<int>(std::ceil(params_.share * length)));
    const double wanted = std::clamp(center - 0.5 * size, 0.0, static_cast<double>(length - size));
    begin = static_cast<int>(wanted);
  };
  cv::Rect part;
  place(center_px.x, image.width, part.x, part.width);
  place(center_px.y, image.height, part.y, part.height);
  return part;
}

std::vector<Detection> CloserLook::add(std::vector<Detection> whole, const cv::Mat& bgr,
                                       const std::vector<cv::Rect>& parts, Detector& detector) {
  for (const cv::Rect& part : parts) {
    for (Detection& seen : detector.detect(bgr(part))) {
      seen.box.x += part.x;
      seen.box.y += part.y;
      if (!isCut(seen.box, part, bgr.size())) whole.push_back(std::move(seen));
    }
  }
  return suppressDuplicates(std::move(whole), kSameThing, std::numeric_limits<int>::max());
}

}  // namespace frugal_nav
