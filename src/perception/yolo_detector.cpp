#include "detector_support.hpp"

#include <algorithm>

#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>

#include <frugal_nav/perception/yolo_detector.hpp>

namespace frugal_nav {
namespace {

Fit fitOf(const std::string& name) {
  if (name == "corner") return Fit::kCorner;
  return name == "stretch" ? Fit::kStretch : Fit::kLetterbox;
}

const std::vector<std::string>& namesOf(const std::vector<std::string>& labels) {
  return labels == std::vector<std::string>{"coco"} ? cocoLabels() : labels;
}

const char* nameOf(YoloLayout layout) {
  switch (layout) {
    case YoloLayout::kYolov8:
      return "yolov8";
    case YoloLayout::kYolox:
      return "yolox";
    case YoloLayout::kRawHeads:
      return "raw_heads";
    case YoloLayout::kEndToEnd:
      return "end_to_end";
    case YoloLayout::kYolov5:
      break;
  }
  return "yolov5";
}

}  // namespace

std::string YoloParams::check() const {
  if (mean.size() != 3) return "mean must have three numbers";
  if (kind == "darknet" && weights.empty()) return "kind darknet needs weights";
  if (kind != "darknet" && kind != "auto" && !weights.empty()) return "weights are for kind darknet only";
  const std::vector<std::string>& names = namesOf(labels);
  for (const std::string& label : wanted) {
    if (std::find(names.begin(), names.end(), label) == names.end()) {
      return "wanted \"" + label + "\" is not among the labels";
    }
  }
  return {};
}

YoloDetector::YoloDetector(const YoloParams& params, const std::string& folder)
    : params_(validated(params, "detector " + params.model)),
      labels_(namesOf(params.labels)),
      fit_(fitOf(params.fit)),
      options_{params.model, cv::Size(params.input_width_px, params.input_height_px),
               static_cast<int>(labels_.size()), params.min_score},
      anchors_{params.kind == "raw_heads_exp" ? BoxCoding::kDarknet : BoxCoding::kYolov5, params.anchors,
               params.scale_xy},
      network_(inFolder(folder, params.model), inFolder(folder, params.weights)) {
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    const bool is_wanted = std::count(params.wanted.begin(), params.wanted.end(), labels_[i]) > 0;
    if (is_wanted) wanted_.push_back(static_cast<int>(i));
  }
  options_.network = network_.file();
  infer(cv::Mat(options_.input, CV_8UC3, cv::Scalar::all(114)));
}

DecodedBoxes YoloDetector::infer(const cv::Mat& input) {
  const cv::Scalar mean(params_.mean[0], params_.mean[1], params_.mean[2]);
  const cv::Mat blob =
      cv::dnn::blobFromImage(input, params_.scale, cv::Size(), mean, params_.color_order == "rgb");
  const std::vector<cv::Mat> outputs = valuesOf(network_.run(blob));
  if (params_.kind == "auto") recognise(outputs);
  return decode(outputs);
}

void YoloDetector::recognise(const std::vector<cv::Mat>& outputs) {
  params_.kind = params_.weights.empty() ? nameOf(recogniseLayout(outputs, options_)) : "darknet";
}

DecodedBoxes YoloDetector::decode(const std::vector<cv::Mat>& outputs) const {
  const std::string& kind = params_.kind;
  if (kind == "darknet") return decodeDarknet(outputs, options_);
  if (kind == "raw_heads" || kind == "raw_heads_exp") return decodeRawHeads(outputs, anchors_, options_);
  if (outputs.size() != 1) {
    throw ConfigError("network " + options_.network + " has " + std::to_string(outputs.size()) +
                      " outputs, but kind " + kind +
                      " has one: correct the kind, or export it with its grid");
  }
  const cv::Mat& output = outputs.front();
  if (kind == "end_to_end") return decodeEndToEnd(output, options_);
  if (kind == "yolov8") return decodeYolov8(output, options_);
  if (kind == "yolox") return decodeYolox(output, options_);
  return decodeYolov5(output, options_);
}

std::vector<Detection> YoloDetector::detect(const cv::Mat& bgr) {
  if (!accept(bgr)) return {};
  const Letterbox letterbox(bgr.size(), options_.input, fit_);
  DecodedBoxes decoded = infer(letterbox.apply(bgr));
  counts_.not_finite += decoded.not_finite;
  std::vector<Detection>& boxes = decoded.boxes;
  boxes.erase(std::remove_if(boxes.begin(), boxes.end(),
                             [this](const Detection& box) { return !isWanted(box.class_id); }),
              boxes.end());
  boxes = suppressDuplicates(std::move(boxes), params_.max_iou, params_.max_detections);
  for (Detection& box : boxes) box.label = labelOf(box.class_id);
  return intoImage(std::move(boxes), letterbox, bgr.size());
}

bool YoloDetector::isWanted(int class_id) const {
  return wanted_.empty() || std::find(wanted_.begin(), wanted_.end(), class_id) != wanted_.end();
}

std::string YoloDetector::labelOf(int class_id) const {
  const bool is_named = class_id >= 0 && class_id < static_cast<int>(labels_.size());
  return is_named ? labels_[static_cast<std::size_t>(class_id)] : std::to_string(class_id);
}

}  // namespace frugal_nav
