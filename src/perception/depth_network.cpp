#include "detector_support.hpp"

#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/perception/depth_network.hpp>

namespace frugal_nav {
namespace {

constexpr double kNearest_m = 0.05;  // a metric network's smaller depths are no depths
constexpr const char* kWanted = "a depth network gives one map, 1xHxW or 1x1xHxW";

/// An output as a map: (1, H, W), (1, 1, H, W) or (H, W).
cv::Mat mapOf(const cv::Mat& value, const std::string& file) {
  bool is_map = value.dims >= 2 && value.dims <= 4 && value.type() == CV_32F;
  for (int i = 0; is_map && i < value.dims - 2; ++i) is_map = value.size[i] == 1;
  is_map = is_map && value.size[value.dims - 1] > 1 && value.size[value.dims - 2] > 1;
  if (!is_map) {
    throw ConfigError("network " + file + " gives " + shapeText(value) + ": " + kWanted +
                      "; name another file in the parameter model");
  }
  const int size[] = {value.size[value.dims - 2], value.size[value.dims - 1]};
  return value.reshape(1, 2, size);
}

std::string namesOf(const std::vector<NetworkOutput>& outputs) {
  std::string names;
  for (const NetworkOutput& output : outputs) names += (names.empty() ? "" : ", ") + output.name;
  return names;
}

/// Depth and, where a name is given for it, floor among the outputs.
DepthPrediction choose(const std::vector<NetworkOutput>& outputs, const std::string& floor_name,
                       const std::string& file) {
  DepthPrediction chosen;
  std::size_t others = 0;
  for (const NetworkOutput& output : outputs) {
    if (!floor_name.empty() && output.name == floor_name) {
      chosen.floor = mapOf(output.value, file);
    } else {
      chosen.inverse = output.value;
      ++others;
    }
  }
  if (!floor_name.empty() && chosen.floor.empty()) {
    throw ConfigError("network " + file + " has no output " + floor_name + " but " + namesOf(outputs) +
                      ": correct or clear the parameter floor_output");
  }
  if (others != 1) {
    throw ConfigError("network " + file + " has " + std::to_string(outputs.size()) + " outputs (" +
                      namesOf(outputs) + "): " + kWanted + "; name another file in the parameter model");
  }
  chosen.inverse = mapOf(chosen.inverse, file);
  return chosen;
}

}  // namespace

std::string DepthNetworkParams::check() const {
  if (mean.size() != 3) return "mean must have three numbers";
  return std.size() == 3 ? "" : "std must have three numbers";
}

OnnxDepthNetwork::OnnxDepthNetwork(const DepthNetworkParams& params, const std::string& folder)
    : params_(validated(params, "depth network " + params.model)), network_(inFolder(folder, params.model)) {
  infer(cv::Mat(params_.input_height_px, params_.input_width_px, CV_8UC3, cv::Scalar::all(114)));
}

cv::Mat OnnxDepthNetwork::blobOf(const cv::Mat& bgr) const {
  const cv::Size size(params_.input_width_px, params_.input_height_px);
  cv::Mat resized;
  // Averaging over areas keeps fine textures from turning into false ones.
  const bool shrinks = size.width < bgr.cols && size.height < bgr.rows;
  cv::resize(bgr, resized, size, 0.0, 0.0, shrinks ? cv::INTER_AREA : cv::INTER_LINEAR);
  if (params_.color_order == "rgb") cv::cvtColor(resized, resized, cv::COLOR_BGR2RGB);
  cv::Mat input;
  resized.convertTo(input, CV_32FC3, params_.scale);
  if (!params_.is_normalised_inside) {
    const auto inverse = [this](std::size_t i) { return 1.0 / params_.std[i]; };
    input -= cv::Scalar(params_.mean[0], params_.mean[1], params_.mean[2]);
    cv::multiply(input, cv::Scalar(inverse(0), inverse(1), inverse(2)), input);
  }
  return cv::dnn::blobFromImage(input);
}

DepthPrediction OnnxDepthNetwork::infer(const cv::Mat& bgr) {
  DepthPrediction prediction = choose(network_.run(blobOf(bgr)), params_.floor_output, network_.file());
  const cv::Mat map = prediction.inverse;
  // max() lets no NaN through, so that it is asked for before.
  prediction.inverse = isMetric() ? cv::Mat(1.0 / cv::max(map, kNearest_m)) : cv::Mat(cv::max(map, 0.0));
  prediction.inverse.setTo(cv::Scalar(std::numeric_limits<double>::quiet_NaN()), map != map);
  prediction.floor = prediction.floor.clone();  // outlives the network's next run
  return prediction;
}

}  // namespace frugal_nav
