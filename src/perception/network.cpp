#include <fstream>

#include <opencv2/core.hpp>
#include <opencv2/dnn.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/network.hpp>

namespace frugal_nav {
namespace {

void requireFile(const std::string& file) {
  if (file.empty()) throw ConfigError("no network file is given: set the parameter that names the model");
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) {
    throw ConfigError("network file " + file +
                      " cannot be opened: put the model there or correct the parameter that names it");
  }
  if (in.tellg() <= 0) throw ConfigError("network file " + file + " is empty: fetch it again");
}

/// OpenCV reads past the end of a Darknet weights file without a word: its length is the one sign of a
/// broken download. A header of four or five 32-bit integers stands before the numbers.
void requireAllWeights(cv::dnn::Net& net, const std::string& weights_file) {
  std::size_t numbers = 0;
  for (const cv::String& name : net.getLayerNames()) {
    const cv::Ptr<cv::dnn::Layer> layer = net.getLayer(net.getLayerId(name));
    if (layer->type == "Region") continue;  // its numbers are the .cfg's anchors
    for (const cv::Mat& blob : layer->blobs) numbers += blob.total();
  }
  std::ifstream in(weights_file, std::ios::binary | std::ios::ate);
  const auto bytes = static_cast<std::size_t>(in.tellg());
  const std::size_t wanted = 16 + numbers * sizeof(float);
  if (bytes < wanted) {
    throw ConfigError("network file " + weights_file + " holds " + std::to_string(bytes) +
                      " bytes, its .cfg needs " + std::to_string(wanted) +
                      ": fetch it again, or the .cfg that belongs to it");
  }
}

}  // namespace

struct Network::Impl {
  cv::dnn::Net net;
  std::vector<cv::String> outputs;
};

Network::Network(const std::string& model_file, const std::string& weights_file)
    : model_file_(model_file), impl_(std::make_unique<Impl>()) {
  requireFile(model_file);
  if (!weights_file.empty()) requireFile(weights_file);
  try {
    impl_->net = weights_file.empty() ? cv::dnn::readNetFromONNX(model_file)
                                      : cv::dnn::readNetFromDarknet(model_file, weights_file);
  } catch (const cv::Exception& error) {
    throw ConfigError("network file " + model_file + " cannot be read as " +
                      (weights_file.empty() ? "ONNX" : "Darknet") +
                      ": fetch it again, or export it for OpenCV " + CV_VERSION + " (" + error.err + ")");
  }
  if (impl_->net.empty()) throw ConfigError("network file " + model_file + " holds no layers");
  if (!weights_file.empty()) requireAllWeights(impl_->net, weights_file);
  impl_->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  impl_->net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  impl_->outputs = impl_->net.getUnconnectedOutLayersNames();
}

Network::~Network() = default;
Network::Network(Network&&) noexcept = default;
Network& Network::operator=(Network&&) noexcept = default;

std::vector<NetworkOutput> Network::run(const cv::Mat& blob) {
  std::vector<cv::Mat> values;
  try {
    impl_->net.setInput(blob);
    impl_->net.forward(values, impl_->outputs);
  } catch (const cv::Exception& error) {
    throw ConfigError("network " + model_file_ + " does not take an input of " + shapeText(blob) +
                      ": give the input size it was exported with (" + error.err + ")");
  }
  std::vector<NetworkOutput> outputs;
  for (std::size_t i = 0; i < values.size(); ++i) outputs.push_back({impl_->outputs[i], values[i]});
  return outputs;
}

std::string shapeText(const cv::Mat& matrix) {
  std::string text;
  for (int i = 0; i < matrix.dims; ++i) text += (i == 0 ? "" : "x") + std::to_string(matrix.size[i]);
  return text.empty() ? "nothing" : text;
}

}  // namespace frugal_nav
