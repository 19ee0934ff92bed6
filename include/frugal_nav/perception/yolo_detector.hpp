#pragma once

#include <string>
#include <vector>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/detector.hpp>
#include <frugal_nav/perception/letterbox.hpp>
#include <frugal_nav/perception/network.hpp>
#include <frugal_nav/perception/yolo_decoders.hpp>

namespace frugal_nav {

/// A YOLO network: its files, its input and output conventions, and what is wanted of it.
struct YoloParams {
  std::string model;
  std::string weights;
  std::string kind = "auto";
  int input_width_px = 640;
  int input_height_px = 640;
  std::string color_order = "rgb";
  std::string fit = "letterbox";
  double scale = 1.0 / 255.0;
  std::vector<double> mean = {0.0, 0.0, 0.0};
  std::vector<double> anchors;
  std::vector<double> scale_xy;
  std::vector<std::string> labels;
  std::vector<std::string> wanted;
  double min_score = 0.25;
  double max_iou = 0.45;
  int max_detections = 100;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("model", model, Field{"", "the network's file: ONNX, or a Darknet .cfg"});
    visit("weights", weights, Field{"", "the .weights file that belongs to a Darknet .cfg; empty for ONNX"});
    visit("kind", kind,
          Field{"", "layout of the outputs; auto tells it from their shapes", -1, 1,
                "auto|yolov5|yolov7|yolov8|yolox|raw_heads|raw_heads_exp|end_to_end|darknet"});
    visit("input_width_px", input_width_px, Field{"px", "width the network was exported with", 32, 4096});
    visit("input_height_px", input_height_px, Field{"px", "height the network was exported with", 32, 4096});
    visit("color_order", color_order, Field{"", "order of the input's channels", -1, 1, "rgb|bgr"});
    visit("fit", fit,
          Field{"", "how the image fills the input: padded evenly, padded right and below, or stretched", -1,
                1, "letterbox|corner|stretch"});
    visit("scale", scale, Field{"", "factor of the pixels' values, after the mean is taken off", 1e-6, 10.0});
    visit("mean", mean, Field{"", "taken off the pixels' values, in the input's order of channels", 0, 255});
    visit("anchors", anchors,
          Field{"px", "raw heads only: width and height of each anchor, those of the finest head first", 0.0,
                4096.0});
    visit("scale_xy", scale_xy,
          Field{"", "raw_heads_exp only: Darknet's scale_x_y of each head, the finest first; empty: 1", 1.0,
                4.0});
    visit("labels", labels,
          Field{"", "names of the classes, in the network's order; coco alone: COCO's 80; empty: numbers"});
    visit("wanted", wanted, Field{"", "labels to look for; empty: all"});
    visit("min_score", min_score, Field{"", "detections of a lower score are left out", 0.001, 1.0});
    visit("max_iou", max_iou,
          Field{"", "of boxes of one class that overlap more, the best stays: 0.45 parts two people", 0.0,
                1.0});
    visit("max_detections", max_detections, Field{"", "most detections of an image", 1, 10000});
  }
  std::string check() const;
};

/// The names of COCO's 80 classes, in its order.
const std::vector<std::string>& cocoLabels();

/// A YOLO detector run by OpenCV's DNN module.
class YoloDetector : public Detector {
 public:
  /// Relative file names are taken to be in `folder`. Runs the network once, so that a wrong file, size or
  /// kind shows here: throws ConfigError naming the file, what was found and what to do.
  explicit YoloDetector(const YoloParams& params, const std::string& folder = "");

  std::vector<Detection> detect(const cv::Mat& bgr) override;

 private:
  DecodedBoxes infer(const cv::Mat& input);
  DecodedBoxes decode(const std::vector<cv::Mat>& outputs) const;
  void recognise(const std::vector<cv::Mat>& outputs);
  bool isWanted(int class_id) const;
  std::string labelOf(int class_id) const;

  YoloParams params_;
  std::vector<std::string> labels_;
  Fit fit_;
  DecodeOptions options_;
  AnchorOptions anchors_;
  std::vector<int> wanted_;
  Network network_;
};

}  // namespace frugal_nav
