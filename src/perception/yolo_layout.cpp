#include "decode_support.hpp"

#include <algorithm>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/network.hpp>
#include <frugal_nav/perception/yolo_decoders.hpp>

namespace frugal_nav {

YoloLayout recogniseLayout(const std::vector<cv::Mat>& outputs, const DecodeOptions& options) {
  std::string found;
  bool all_heads = outputs.size() > 1;
  for (const cv::Mat& output : outputs) {
    found += (found.empty() ? "" : ", ") + shapeText(output);
    all_heads = all_heads && output.dims >= 4;
  }
  if (all_heads) return YoloLayout::kRawHeads;
  if (outputs.size() == 1) {
    const cv::Mat& output = outputs.front();
    if (output.dims == 2 && output.size[1] == kEndToEndFields) return YoloLayout::kEndToEnd;
    if (output.dims == 3 && output.size[0] == 1) {
      const int rows = output.size[1];
      const int width = output.size[2];
      if (rows > kBoxFields && rows < width) return YoloLayout::kYolov8;
      // Anchor-free YOLOX has one row a cell, the anchored ones three.
      if (width > kObjectFields) {
        return rows == cellCount(options.input) ? YoloLayout::kYolox : YoloLayout::kYolov5;
      }
    }
  }
  throw ConfigError(
      "network " + options.network + " has outputs of shape " + found +
      ", which is no YOLO layout known here (1xNx(5 + classes), 1x(4 + classes)xN, Nx7, three raw "
      "heads): give a detector's model");
}

std::vector<Detection> suppressDuplicates(std::vector<Detection> boxes, double max_iou, int max_count) {
  std::stable_sort(boxes.begin(), boxes.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  std::vector<Detection> kept;
  for (Detection& box : boxes) {
    if (static_cast<int>(kept.size()) >= max_count) break;
    const bool is_new = std::none_of(kept.begin(), kept.end(), [&](const Detection& other) {
      const double overlap = (box.box & other.box).area();
      return other.class_id == box.class_id &&
             overlap > max_iou * (box.box.area() + other.box.area() - overlap);
    });
    if (is_new) kept.push_back(std::move(box));
  }
  return kept;
}

}  // namespace frugal_nav
