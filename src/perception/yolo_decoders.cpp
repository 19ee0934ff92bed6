#include "decode_support.hpp"

#include <cmath>
#include <optional>

#include <opencv2/core.hpp>

#include <frugal_nav/perception/yolo_decoders.hpp>

namespace frugal_nav {
namespace {

/// Rows of a (1, N, width), (N, width) output.
struct Rows {
  const float* first = nullptr;
  int count = 0;
  int width = 0;

  const float* row(int i) const { return first + static_cast<std::ptrdiff_t>(i) * width; }
};

/// The rows of a (1, N, width) or (N, width) output; nullopt when it is no such list.
std::optional<Rows> rowsOf(const cv::Mat& output) {
  const int dims = output.dims;
  const bool is_list = dims == 2 || (dims == 3 && output.size[0] == 1);
  if (!is_list) return std::nullopt;
  return Rows{output.ptr<float>(), output.size[dims - 2], output.size[dims - 1]};
}

/// Rows of `fixed` numbers and one score a class.
Rows classRows(const cv::Mat& output, int fixed, const std::string& wanted, const DecodeOptions& options) {
  requireFloats(output, options);
  const std::optional<Rows> rows = rowsOf(output);
  const bool fits =
      rows && rows->width > fixed && (options.classes == 0 || rows->width == fixed + options.classes);
  if (!fits) refuseShape(options, output, wanted);
  return *rows;
}

/// Class and score of a row whose scores are to be multiplied by its objectness.
Best bestTimesObjectness(const float* row, int width, bool objectness_alone) {
  if (objectness_alone) return {0, row[kBoxFields]};
  Best best = bestOf(row + kObjectFields, width - kObjectFields);
  best.score *= row[kBoxFields];
  return best;
}

}  // namespace

DecodedBoxes decodeYolov5(const cv::Mat& output, const DecodeOptions& options) {
  const Rows rows = classRows(output, kObjectFields, "1xNx" + classFields(kObjectFields, options), options);
  DecodedBoxes decoded;
  for (int i = 0; i < rows.count; ++i) {
    const float* row = rows.row(i);
    if (!isWorthDecoding(row, rows.width, row[kBoxFields], options, decoded)) continue;
    const Best best = bestTimesObjectness(row, rows.width, rows.width == kObjectFields + 1);
    addBox(best.class_id, best.score, boxAround(row[0], row[1], row[2], row[3]), options, decoded);
  }
  return decoded;
}

DecodedBoxes decodeYolov8(const cv::Mat& output, const DecodeOptions& options) {
  const std::string wanted = "1x" + classFields(kBoxFields, options) + "xN";
  requireFloats(output, options);
  if (output.dims != 3 || output.size[0] != 1) refuseShape(options, output, wanted);
  const cv::Mat channels(output.size[1], output.size[2], CV_32F, const_cast<float*>(output.ptr<float>()));
  if (channels.rows <= kBoxFields || (options.classes > 0 && channels.rows != kBoxFields + options.classes)) {
    refuseShape(options, output, wanted);
  }
  const cv::Mat rows = channels.t();
  DecodedBoxes decoded;
  for (int i = 0; i < rows.rows; ++i) {
    const float* row = rows.ptr<float>(i);
    if (!isWorthDecoding(row, rows.cols, 1.0, options, decoded)) continue;
    const Best best = bestOf(row + kBoxFields, rows.cols - kBoxFields);
    addBox(best.class_id, best.score, boxAround(row[0], row[1], row[2], row[3]), options, decoded);
  }
  return decoded;
}

DecodedBoxes decodeYolox(const cv::Mat& output, const DecodeOptions& options) {
  const int cells = cellCount(options.input);
  const std::string wanted = "1x" + std::to_string(cells) + "x" + classFields(kObjectFields, options);
  const Rows rows = classRows(output, kObjectFields, wanted, options);
  if (rows.count != cells) refuseShape(options, output, wanted);
  DecodedBoxes decoded;
  int i = 0;
  for (const int stride : kStrides) {
    const int columns = options.input.width / stride;
    const int end = i + cellCount(options.input, stride);
    for (int cell = 0; i < end; ++i, ++cell) {
      const float* row = rows.row(i);
      if (!isWorthDecoding(row, rows.width, row[kBoxFields], options, decoded)) continue;
      const Best best = bestTimesObjectness(row, rows.width, false);
      const double cx = stride * (static_cast<double>(row[0]) + cell % columns);
      const double cy = stride * (static_cast<double>(row[1]) + cell / columns);
      const cv::Rect2d box = boxAround(cx, cy, stride * std::exp(static_cast<double>(row[2])),
                                       stride * std::exp(static_cast<double>(row[3])));
      addBox(best.class_id, best.score, box, options, decoded);
    }
  }
  return decoded;
}

DecodedBoxes decodeEndToEnd(const cv::Mat& output, const DecodeOptions& options) {
  DecodedBoxes decoded;
  if (output.empty() && output.dims <= 2) return decoded;  // OpenCV's form of no rows at all
  requireFloats(output, options);
  const std::optional<Rows> rows = rowsOf(output);
  if (!rows || rows->width != kEndToEndFields) refuseShape(options, output, "Nx7");
  for (int i = 0; i < rows->count; ++i) {
    const float* row = rows->row(i);
    if (!isWorthDecoding(row, rows->width, row[6], options, decoded) || row[0] != 0.0F) continue;
    const cv::Rect2d box(row[1], row[2], row[3] - row[1], row[4] - row[2]);
    addBox(static_cast<int>(row[5]), row[6], box, options, decoded);
  }
  return decoded;
}

DecodedBoxes decodeDarknet(const std::vector<cv::Mat>& outputs, const DecodeOptions& options) {
  DecodedBoxes decoded;
  for (const cv::Mat& output : outputs) {
    const Rows rows = classRows(output, kObjectFields, "Nx" + classFields(kObjectFields, options), options);
    for (int i = 0; i < rows.count; ++i) {
      const float* row = rows.row(i);
      if (!isWorthDecoding(row, rows.width, row[kBoxFields], options, decoded)) continue;
      const Best best = bestOf(row + kObjectFields, rows.width - kObjectFields);
      const double w = options.input.width;
      const double h = options.input.height;
      addBox(best.class_id, best.score, boxAround(w * row[0], h * row[1], w * row[2], h * row[3]), options,
             decoded);
    }
  }
  return decoded;
}

}  // namespace frugal_nav
