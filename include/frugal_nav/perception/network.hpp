#pragma once

#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace frugal_nav {

/// One output of a network. Its memory is the network's: good until the next run.
struct NetworkOutput {
  std::string name;
  cv::Mat value;
};

/// A neural network read by OpenCV's DNN module, on the CPU.
class Network {
 public:
  /// Reads an ONNX model, or a Darknet one when `weights_file` is not empty (then `model_file` is its .cfg).
  /// Throws ConfigError naming the file and what to do when one is missing, broken or not supported.
  explicit Network(const std::string& model_file, const std::string& weights_file = "");
  ~Network();
  Network(Network&&) noexcept;
  Network& operator=(Network&&) noexcept;

  /// All outputs for an input in NCHW. Throws ConfigError when the network cannot take an input of that
  /// shape.
  std::vector<NetworkOutput> run(const cv::Mat& blob);

  const std::string& file() const { return model_file_; }

 private:
  struct Impl;
  std::string model_file_;
  std::unique_ptr<Impl> impl_;
};

/// The sizes of a matrix, as "1x25200x85".
std::string shapeText(const cv::Mat& matrix);

}  // namespace frugal_nav
