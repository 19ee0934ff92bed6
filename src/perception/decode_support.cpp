#include "decode_support.hpp"

#include <algorithm>
#include <cmath>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/network.hpp>

namespace frugal_nav {

void refuseShape(const DecodeOptions& options, const cv::Mat& found, const std::string& wanted) {
  throw ConfigError("network " + options.network + ": an output has shape " + shapeText(found) +
                    ", but this kind of detector wants " + wanted +
                    ": correct the kind, the input size or the labels, or export the network anew");
}

void requireFloats(const cv::Mat& output, const DecodeOptions& options) {
  if (output.depth() != CV_32F || output.channels() != 1 || !output.isContinuous()) {
    throw ConfigError("network " + options.network + ": an output is not of 32-bit floats");
  }
}

bool allFinite(const float* numbers, int count) {
  float zero = 0.0F;
  for (int i = 0; i < count; ++i) zero += numbers[i] * 0.0F;  // inf * 0 and NaN * 0 are NaN
  return zero == 0.0F;
}

int cellCount(const cv::Size& input) {
  int cells = 0;
  for (const int stride : kStrides) cells += cellCount(input, stride);
  return cells;
}

std::string classFields(int fixed, const DecodeOptions& options) {
  return options.classes > 0 ? std::to_string(fixed + options.classes)
                             : "(" + std::to_string(fixed) + " + classes)";
}

Best bestOf(const float* scores, int count) {
  const float* best = std::max_element(scores, scores + count);
  return {static_cast<int>(best - scores), *best};
}

bool isWorthDecoding(const float* row, int width, double objectness, const DecodeOptions& options,
                     DecodedBoxes& decoded) {
  // A class score is at most one: most rows fall out here, before the whole row is read.
  if (objectness < options.min_score) return false;
  if (allFinite(row, width)) return true;
  ++decoded.not_finite;
  return false;
}

void addBox(int class_id, double score, const cv::Rect2d& box, const DecodeOptions& options,
            DecodedBoxes& decoded) {
  if (score < options.min_score) return;
  if (!std::isfinite(box.x + box.y + box.width + box.height)) {
    ++decoded.not_finite;
  } else if (box.width > 0.0 && box.height > 0.0) {
    decoded.boxes.push_back({class_id, "", std::min(score, 1.0), box});
  }
}

}  // namespace frugal_nav
