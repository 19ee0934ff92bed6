#include "decode_support.hpp"
#include "detector_support.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>

#include <frugal_nav/perception/face_detectors.hpp>

namespace frugal_nav {
namespace {

constexpr int kLandmarkFields = 10;

/// The four outputs of one stride.
struct Scale {
  std::vector<const float*> scores;  // class and objectness
  const float* boxes = nullptr;
  const float* landmarks = nullptr;

  bool isComplete() const { return scores.size() == 2 && boxes != nullptr && landmarks != nullptr; }
};

[[noreturn]] void refuseOutputs(const std::vector<cv::Mat>& outputs, const DecodeOptions& options) {
  std::string found;
  for (const cv::Mat& output : outputs) found += (found.empty() ? "" : ", ") + shapeText(output);
  throw ConfigError("network " + options.network + " has outputs of shape " + found +
                    ", but YuNet has two 1xNx1, one 1xNx4 and one 1xNx10 for each stride 8, 16 and 32 of a " +
                    std::to_string(options.input.width) + "x" + std::to_string(options.input.height) +
                    " input: give the twelve-output YuNet and its input size");
}

Scale scaleOf(const std::vector<cv::Mat>& outputs, int cells) {
  Scale scale;
  for (const cv::Mat& output : outputs) {
    if (output.dims != 3 || output.size[0] != 1 || output.size[1] != cells) continue;
    const float* first = output.ptr<float>();
    if (output.size[2] == 1) scale.scores.push_back(first);
    if (output.size[2] == kBoxFields) scale.boxes = first;
    if (output.size[2] == kLandmarkFields) scale.landmarks = first;
  }
  return scale;
}

void decodeScale(const Scale& scale, int stride, const DecodeOptions& options, DecodedBoxes& decoded) {
  const int columns = options.input.width / stride;
  for (int cell = 0; cell < cellCount(options.input, stride); ++cell) {
    const double product = static_cast<double>(std::clamp(scale.scores[0][cell], 0.0F, 1.0F)) *
                           std::clamp(scale.scores[1][cell], 0.0F, 1.0F);
    const double score = std::sqrt(product);
    if (score < options.min_score) continue;
    const float* t = scale.boxes + kBoxFields * static_cast<std::ptrdiff_t>(cell);
    if (!std::isfinite(score) || !allFinite(t, kBoxFields)) {
      ++decoded.not_finite;
      continue;
    }
    const double cx = stride * (static_cast<double>(t[0]) + cell % columns);
    const int row = cell / columns;
    const double cy = stride * (static_cast<double>(t[1]) + row);
    addBox(0, score,
           boxAround(cx, cy, stride * std::exp(static_cast<double>(t[2])),
                     stride * std::exp(static_cast<double>(t[3]))),
           options, decoded);
  }
}

}  // namespace

DecodedBoxes decodeYunet(const std::vector<cv::Mat>& outputs, const DecodeOptions& options) {
  for (const cv::Mat& output : outputs) requireFloats(output, options);
  DecodedBoxes decoded;
  for (const int stride : kStrides) {
    const Scale scale = scaleOf(outputs, cellCount(options.input, stride));
    if (!scale.isComplete()) refuseOutputs(outputs, options);
    decodeScale(scale, stride, options, decoded);
  }
  return decoded;
}

YunetDetector::YunetDetector(const YunetParams& params, const std::string& folder)
    : params_(validated(params, "yunet " + params.model)),
      options_{params.model, cv::Size(params.input_width_px, params.input_height_px), 1, params.min_score},
      network_(inFolder(folder, params.model)) {
  options_.network = network_.file();
  infer(cv::Mat(options_.input, CV_8UC3, cv::Scalar::all(114)));
}

DecodedBoxes YunetDetector::infer(const cv::Mat& input) {
  return decodeYunet(valuesOf(network_.run(cv::dnn::blobFromImage(input))), options_);
}

std::vector<Detection> YunetDetector::detect(const cv::Mat& bgr) {
  if (!accept(bgr)) return {};
  const Letterbox letterbox(bgr.size(), options_.input, Fit::kCorner);
  DecodedBoxes decoded = infer(letterbox.apply(bgr));
  counts_.not_finite += decoded.not_finite;
  std::vector<Detection> faces =
      suppressDuplicates(std::move(decoded.boxes), params_.max_iou, params_.max_detections);
  for (Detection& face : faces) face.label = "face";
  return intoImage(std::move(faces), letterbox, bgr.size());
}

}  // namespace frugal_nav
