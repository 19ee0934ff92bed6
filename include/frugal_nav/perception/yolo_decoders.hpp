#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/perception/detection.hpp>

namespace frugal_nav {

/// What decoding a network's outputs needs to know.
struct DecodeOptions {
  std::string network;     ///< stands in the messages
  cv::Size input;          ///< of the network [px]
  int classes = 0;         ///< number the outputs must have; 0: as many as their shape says
  double min_score = 0.0;  ///< lower ones are left out
};

/// Boxes in pixels of the network's input, before suppression of duplicates.
struct DecodedBoxes {
  std::vector<Detection> boxes;  ///< without labels
  std::uint64_t not_finite = 0;  ///< rows left out because a number in them is not finite
};

/// How raw heads code a box in a cell (gx, gy) with an anchor (aw, ah), s the sigmoid of a number.
enum class BoxCoding {
  kYolov5,  ///< centre (2 s(t) - 0.5 + g) stride, size (2 s(t))^2 a: YOLOv5, YOLOv7
  kDarknet  ///< centre (k s(t) - (k - 1) / 2 + g) stride, size exp(t) a: YOLOv3, YOLOv4, k = scale_xy
};

/// What raw heads do not say themselves.
struct AnchorOptions {
  BoxCoding coding = BoxCoding::kYolov5;
  std::vector<double> anchors;   ///< width, height, width, ... [px], of the finest head first
  std::vector<double> scale_xy;  ///< k of each head, of the finest first; empty: 1
};

// Every decoder throws ConfigError naming the network, the shape it found and the shape it wants when an
// output is of another one.

/// YOLOv5 and YOLOv7 with the grid exported: (1, N, 5 + nc), centre and size in pixels. The score is
/// objectness times class; objectness alone when there is one class.
DecodedBoxes decodeYolov5(const cv::Mat& output, const DecodeOptions& options);

/// YOLOv8: (1, 4 + nc, N), centre and size in pixels; the score is the class's.
DecodedBoxes decodeYolov8(const cv::Mat& output, const DecodeOptions& options);

/// YOLOX without its grid: (1, N, 5 + nc) over strides 8, 16, 32, centre as offset in the cell and size as
/// logarithm, both in strides. The score is objectness times class.
DecodedBoxes decodeYolox(const cv::Mat& output, const DecodeOptions& options);

/// Heads before the sigmoid, in any order: each (1, A, ny, nx, 5 + nc) or (1, A (5 + nc), ny, nx) with A
/// anchors. The score is as in decodeYolov5.
DecodedBoxes decodeRawHeads(const std::vector<cv::Mat>& heads, const AnchorOptions& anchors,
                            const DecodeOptions& options);

/// Exports that suppress duplicates themselves: (N, 7) or (1, N, 7), batch, x0, y0, x1, y1 in pixels, class,
/// score. Rows of another image of the batch are padding.
DecodedBoxes decodeEndToEnd(const cv::Mat& output, const DecodeOptions& options);

/// OpenCV's Darknet region layers: each (N, 5 + nc), centre and size as shares of the image, objectness, and
/// class scores that include it already.
DecodedBoxes decodeDarknet(const std::vector<cv::Mat>& outputs, const DecodeOptions& options);

/// How a network's outputs are laid out.
enum class YoloLayout { kYolov5, kYolov8, kYolox, kRawHeads, kEndToEnd };

/// The layout an ONNX network's outputs have, told from their shapes and the input's size. Throws ConfigError
/// naming the network and what was found when it is none.
YoloLayout recogniseLayout(const std::vector<cv::Mat>& outputs, const DecodeOptions& options);

/// Greedy non-maximum suppression: best scores first, of boxes of one class that overlap by more than
/// `max_iou` the best alone; at most `max_count`, sorted by falling score.
std::vector<Detection> suppressDuplicates(std::vector<Detection> boxes, double max_iou, int max_count);

}  // namespace frugal_nav
