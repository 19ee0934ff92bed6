#include "decode_support.hpp"

#include <algorithm>
#include <cmath>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/yolo_decoders.hpp>

namespace frugal_nav {
namespace {

double sigmoid(double x) { return 1.0 / (1.0 + std::exp(-x)); }

/// One raw head, in either of its layouts.
struct Head {
  const float* data = nullptr;
  int anchors = 0;
  int rows = 0;
  int columns = 0;
  int fields = 0;
  bool fields_last = true;

  float at(int anchor, int row, int column, int field) const {
    const std::ptrdiff_t cell = static_cast<std::ptrdiff_t>(rows) * columns;
    const std::ptrdiff_t index = static_cast<std::ptrdiff_t>(row) * columns + column;
    return fields_last ? data[(anchor * cell + index) * fields + field]
                       : data[(static_cast<std::ptrdiff_t>(anchor) * fields + field) * cell + index];
  }
};

Head headOf(const cv::Mat& output, int anchors, const DecodeOptions& options) {
  const std::string a = std::to_string(anchors);
  const std::string fields = classFields(kObjectFields, options);
  const std::string wanted =
      "1x" + a + "xNYxNXx" + fields + " or 1x(" + a + " * " + fields + ")xNYxNX with cells of one size";
  requireFloats(output, options);
  Head head;
  head.data = output.ptr<float>();
  head.anchors = anchors;
  if (output.dims == 5 && output.size[0] == 1 && output.size[1] == anchors) {
    head.rows = output.size[2];
    head.columns = output.size[3];
    head.fields = output.size[4];
  } else if (output.dims == 4 && output.size[0] == 1 && output.size[1] % anchors == 0) {
    head.fields_last = false;
    head.fields = output.size[1] / anchors;
    head.rows = output.size[2];
    head.columns = output.size[3];
  }
  const bool fits = head.fields > kObjectFields &&
                    (options.classes == 0 || head.fields == kObjectFields + options.classes) &&
                    options.input.width % head.columns == 0 &&
                    options.input.width / head.columns * head.rows == options.input.height;
  if (!fits) refuseShape(options, output, wanted);
  return head;
}

cv::Rect2d anchorBox(const float* t, int row, int column, double stride, const double* anchor,
                     BoxCoding coding, double k) {
  const auto centre = [&](double s, int cell) {
    return coding == BoxCoding::kYolov5 ? (2.0 * s - 0.5 + cell) * stride
                                        : (k * s - 0.5 * (k - 1.0) + cell) * stride;
  };
  const auto size = [&](double value, double length) {
    return coding == BoxCoding::kYolov5 ? std::pow(2.0 * sigmoid(value), 2) * length
                                        : std::exp(value) * length;
  };
  return boxAround(centre(sigmoid(t[0]), column), centre(sigmoid(t[1]), row), size(t[2], anchor[0]),
                   size(t[3], anchor[1]));
}

void decodeHead(const Head& head, const double* anchors, BoxCoding coding, double k,
                const DecodeOptions& options, DecodedBoxes& decoded) {
  const double stride = static_cast<double>(options.input.width) / head.columns;
  std::vector<float> t(static_cast<std::size_t>(head.fields));
  for (int anchor = 0; anchor < head.anchors; ++anchor) {
    for (int cell = 0; cell < head.rows * head.columns; ++cell) {
      const int row = cell / head.columns;
      const int column = cell % head.columns;
      if (sigmoid(head.at(anchor, row, column, kBoxFields)) < options.min_score) continue;
      for (int field = 0; field < head.fields; ++field) {
        t[static_cast<std::size_t>(field)] = head.at(anchor, row, column, field);
      }
      if (!isWorthDecoding(t.data(), head.fields, 1.0, options, decoded)) continue;
      const Best best = bestOf(t.data() + kObjectFields, head.fields - kObjectFields);
      const double objectness = sigmoid(t[kBoxFields]);
      const bool one_class = head.fields == kObjectFields + 1;
      addBox(best.class_id, one_class ? objectness : objectness * sigmoid(best.score),
             anchorBox(t.data(), row, column, stride, anchors + 2 * anchor, coding, k), options, decoded);
    }
  }
}

}  // namespace

DecodedBoxes decodeRawHeads(const std::vector<cv::Mat>& heads, const AnchorOptions& anchors,
                            const DecodeOptions& options) {
  const std::size_t count = heads.size();
  if (count == 0 || anchors.anchors.empty() || anchors.anchors.size() % (2 * count) != 0) {
    throw ConfigError("network " + options.network + ": " + std::to_string(anchors.anchors.size()) +
                      " numbers of anchors do not share out among " + std::to_string(count) +
                      " raw heads: give width and height of each anchor, those of the finest head first");
  }
  if (!anchors.scale_xy.empty() && anchors.scale_xy.size() != count) {
    throw ConfigError("network " + options.network + ": scale_xy must have one number for each of the " +
                      std::to_string(count) + " heads");
  }
  const std::size_t per_head = anchors.anchors.size() / (2 * count);
  std::vector<Head> sorted;
  for (const cv::Mat& head : heads) sorted.push_back(headOf(head, static_cast<int>(per_head), options));
  std::sort(sorted.begin(), sorted.end(), [](const Head& a, const Head& b) { return a.columns > b.columns; });
  DecodedBoxes decoded;
  for (std::size_t i = 0; i < count; ++i) {
    decodeHead(sorted[i], &anchors.anchors[i * per_head * 2], anchors.coding,
               anchors.scale_xy.empty() ? 1.0 : anchors.scale_xy[i], options, decoded);
  }
  return decoded;
}

}  // namespace frugal_nav
