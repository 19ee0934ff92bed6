#pragma once

#include <memory>
#include <string>
#include <vector>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/detector.hpp>
#include <frugal_nav/perception/network.hpp>
#include <frugal_nav/perception/yolo_decoders.hpp>

namespace frugal_nav {

/// OpenCV's cascade of Haar features for faces.
struct CascadeFaceParams {
  std::string kind = "cascade";
  std::string cascade_file = "/usr/share/opencv4/haarcascades/haarcascade_frontalface_alt2.xml";
  double scale_step = 1.1;
  int min_neighbors = 4;
  int min_size_px = 24;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("kind", kind, Field{"", "tells this detector from the others", -1, 1, "cascade"});
    visit("cascade_file", cascade_file,
          Field{"", "the cascade; the default is where Debian's package opencv-data puts it"});
    visit("scale_step", scale_step,
          Field{"", "step between the sizes looked for: smaller finds more and takes longer", 1.01, 2.0});
    visit("min_neighbors", min_neighbors,
          Field{"", "overlapping finds that make a face: more lets fewer false ones through", 1, 50});
    visit("min_size_px", min_size_px, Field{"px", "smallest face: about what it was trained on", 8, 2000});
  }
};

/// Faces by a Haar cascade, with no network to fetch. Its scores say how many finds made a face: n / (n + 4).
class CascadeFaceDetector : public Detector {
 public:
  /// Throws ConfigError when the cascade's file is missing or broken, naming the package that holds it.
  explicit CascadeFaceDetector(const CascadeFaceParams& params);
  ~CascadeFaceDetector() override;

  std::vector<Detection> detect(const cv::Mat& bgr) override;

 private:
  struct Impl;
  CascadeFaceParams params_;
  std::unique_ptr<Impl> impl_;
};

/// YuNet, a small network for faces.
struct YunetParams {
  std::string kind = "yunet";
  std::string model;
  int input_width_px = 320;
  int input_height_px = 320;
  double min_score = 0.6;
  double max_iou = 0.3;
  int max_detections = 50;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("kind", kind, Field{"", "tells this detector from the others", -1, 1, "yunet"});
    visit("model", model, Field{"", "the network's ONNX file"});
    visit("input_width_px", input_width_px, Field{"px", "width the network was exported with", 32, 4096});
    visit("input_height_px", input_height_px, Field{"px", "height the network was exported with", 32, 4096});
    visit("min_score", min_score, Field{"", "faces of a lower score are left out", 0.001, 1.0});
    visit("max_iou", max_iou, Field{"", "of faces that overlap more, the best stays", 0.0, 1.0});
    visit("max_detections", max_detections, Field{"", "most faces of an image", 1, 10000});
  }
};

/// Faces from YuNet's twelve outputs: for each stride 8, 16, 32 class and objectness (1, N, 1), box (1, N, 4)
/// and landmarks (1, N, 10). Centre (t + cell) stride, size exp(t) stride, score sqrt(class objectness). The
/// outputs may come in any order: shapes tell them apart, and class and objectness enter alike. Throws
/// ConfigError when one is missing, naming the network and the shapes found.
DecodedBoxes decodeYunet(const std::vector<cv::Mat>& outputs, const DecodeOptions& options);

/// Faces by YuNet in its twelve-output form, run by OpenCV's DNN module.
class YunetDetector : public Detector {
 public:
  /// A relative file name is taken to be in `folder`. Runs the network once; throws ConfigError naming the
  /// file, what was found and what to do.
  explicit YunetDetector(const YunetParams& params, const std::string& folder = "");

  std::vector<Detection> detect(const cv::Mat& bgr) override;

 private:
  DecodedBoxes infer(const cv::Mat& input);

  YunetParams params_;
  DecodeOptions options_;
  Network network_;
};

}  // namespace frugal_nav
