#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/perception/yolo_decoders.hpp>

namespace frugal_nav {

constexpr int kBoxFields = 4;
constexpr int kObjectFields = 5;  // box and objectness
constexpr int kEndToEndFields = 7;
constexpr int kStrides[] = {8, 16, 32};  // of the grids of all the detectors here [px]

/// Throws ConfigError that the network's output has one shape and must have another.
[[noreturn]] void refuseShape(const DecodeOptions& options, const cv::Mat& found, const std::string& wanted);

/// Throws ConfigError unless the output is of continuous 32-bit floats.
void requireFloats(const cv::Mat& output, const DecodeOptions& options);

/// Whether every one of some numbers is finite.
bool allFinite(const float* numbers, int count);

/// Cells of a grid whose cells are `stride_px` wide.
inline int cellCount(const cv::Size& input, int stride_px) {
  return (input.width / stride_px) * (input.height / stride_px);
}

/// Cells of the grids of all strides.
int cellCount(const cv::Size& input);

/// The number of fields a row must have, for messages: `fixed` and one a class.
std::string classFields(int fixed, const DecodeOptions& options);

struct Best {
  int class_id;
  double score;
};

/// The largest of some class scores.
Best bestOf(const float* scores, int count);

/// Whether a row's objectness passes and its numbers are finite; one that is not finite is counted.
bool isWorthDecoding(const float* row, int width, double objectness, const DecodeOptions& options,
                     DecodedBoxes& decoded);

/// A box from its centre and size.
inline cv::Rect2d boxAround(double cx, double cy, double width, double height) {
  return {cx - 0.5 * width, cy - 0.5 * height, width, height};
}

/// Takes a box in when score and box pass; counts it when the box is not finite (an overflowing exp).
void addBox(int class_id, double score, const cv::Rect2d& box, const DecodeOptions& options,
            DecodedBoxes& decoded);

}  // namespace frugal_nav
