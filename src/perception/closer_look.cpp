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
// A box that ends this close to a part's edge is cut off by it: a detector's box ends before what cuts it.
constexpr double kEdge_px = 2.0;
constexpr double kEdgeShare = 0.12;  // of the box's height
// A box that lies in a larger one by this share of itself shows a piece of the same thing.
constexpr double kPiece = 0.8;
constexpr double kLarger = 1.5;
// The larger one must be as sure as this share of the piece.
constexpr double kAsSure = 0.5;

/// Whether a box ends at an edge of the part that is not one of the image.
bool isCut(const cv::Rect2d& box, const cv::Rect& part, const cv::Size& image) {
  const double edge_px = std::max(kEdge_px, kEdgeShare * box.height);
  return (part.x > 0 && box.x < part.x + edge_px) || (part.y > 0 && box.y < part.y + edge_px) ||
         (part.br().x < image.width && box.br().x > part.br().x - edge_px) ||
         (part.br().y < image.height && box.br().y > part.br().y - edge_px);
}

/// Whether one of the first `count` detections is larger and holds the box: half a person in a part of the
/// image is no second one.
bool isPiece(const Detection& seen, const std::vector<Detection>& whole, std::size_t count) {
  const auto end = whole.begin() + static_cast<std::ptrdiff_t>(count);
  return std::any_of(whole.begin(), end, [&seen](const Detection& other) {
    return other.class_id == seen.class_id && other.score >= kAsSure * seen.score &&
           other.box.area() > kLarger * seen.box.area() &&
           (other.box & seen.box).area() >= kPiece * seen.box.area();
  });
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
  const std::size_t count = whole.size();
  for (const cv::Rect& part : parts) {
    for (Detection& seen : detector.detect(bgr(part))) {
      seen.box.x += part.x;
      seen.box.y += part.y;
      if (isCut(seen.box, part, bgr.size()) || isPiece(seen, whole, count)) continue;
      whole.push_back(std::move(seen));
    }
  }
  return suppressDuplicates(std::move(whole), kSameThing, std::numeric_limits<int>::max());
}

}  // namespace frugal_nav
