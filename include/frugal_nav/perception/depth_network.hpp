#pragma once

#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/network.hpp>

namespace frugal_nav {

/// A depth network: its file and its input and output conventions. The defaults are MiDaS v2.1 small's.
struct DepthNetworkParams {
  std::string model;
  std::string output = "inverse";
  std::string floor_output;
  int input_width_px = 256;
  int input_height_px = 256;
  std::string color_order = "rgb";
  double scale = 1.0 / 255.0;
  bool is_normalised_inside = false;
  std::vector<double> mean = {0.485, 0.456, 0.406};
  std::vector<double> std = {0.229, 0.224, 0.225};

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("model", model, Field{"", "the network's file, ONNX"});
    visit("output", output,
          Field{"", "inverse: relative inverse depth, scale and shift unknown; metric: metres", -1, 1,
                "inverse|metric"});
    visit("floor_output", floor_output,
          Field{"", "name of the output that gives the probability of floor; empty: the network has none"});
    visit("input_width_px", input_width_px, Field{"px", "width the network was exported with", 16, 4096});
    visit("input_height_px", input_height_px, Field{"px", "height the network was exported with", 16, 4096});
    visit("color_order", color_order, Field{"", "order of the input's channels", -1, 1, "rgb|bgr"});
    visit("scale", scale,
          Field{"", "factor of the pixels' values, before the mean is taken off", 1e-6, 10.0});
    visit(
        "is_normalised_inside", is_normalised_inside,
        Field{"", "whether the network takes mean and deviation off itself: some exports have it baked in"});
    visit("mean", mean,
          Field{"", "taken off the scaled values, in the input's order of channels", -255, 255});
    visit("std", std, Field{"", "what they are then divided by, likewise", 1e-6, 255.0});
  }
  std::string check() const;
};

/// What a depth network tells of an image: maps of its own size that cover the whole image.
struct DepthPrediction {
  cv::Mat inverse;  ///< CV_32FC1, relative inverse depth, near is large; not finite where there is no number
  cv::Mat floor;    ///< CV_32FC1, probability of floor; empty when the network does not tell
};

/// Depth from one image, up to scale and shift.
class DepthNetwork {
 public:
  virtual ~DepthNetwork() = default;

  /// Looks at an image (CV_8UC3, BGR). A metric network's inverse depth is 1 / metres.
  virtual DepthPrediction infer(const cv::Mat& bgr) = 0;

  /// Whether infer() gives 1 / metres.
  virtual bool isMetric() const = 0;
};

/// A depth network run by OpenCV's DNN module.
class OnnxDepthNetwork : public DepthNetwork {
 public:
  /// A relative file name is taken to be in `folder`. Runs the network once, so that a wrong file, size or
  /// shape shows here: throws ConfigError naming the file, what was found and what to do.
  explicit OnnxDepthNetwork(const DepthNetworkParams& params, const std::string& folder = "");

  DepthPrediction infer(const cv::Mat& bgr) override;
  bool isMetric() const override { return params_.output == "metric"; }

 private:
  cv::Mat blobOf(const cv::Mat& bgr) const;

  DepthNetworkParams params_;
  Network network_;
};

}  // namespace frugal_nav
