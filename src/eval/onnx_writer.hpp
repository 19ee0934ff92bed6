#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace frugal_nav::eval {

/// Shape of an activation; one image.
struct OnnxShape {
  std::int64_t channels = 0;
  std::int64_t height = 0;
  std::int64_t width = 0;
};

/// Writes ONNX networks (opset 11) of the few layers that a test or a timing needs.
class OnnxWriter {
 public:
  /// An input or the output of a layer.
  struct Value {
    std::string name;
    OnnxShape shape;
  };
  struct Convolution {
    std::int64_t out_channels = 1;
    std::int64_t kernel = 3;
    std::int64_t stride = 1;
    bool depthwise = false;
  };

  /// The network's input, 1 x C x H x W.
  explicit OnnxWriter(const OnnxShape& input);

  Value input() const { return {"input", input_}; }
  /// Padded so that the size is that of the input over the stride. `weights` are those of its kernels, output
  /// channel by output channel; the bias is zero.
  Value convolve(const Value& in, const Convolution& convolution, const std::vector<float>& weights);
  /// How many weights that convolution takes.
  static std::int64_t weightsOf(const Value& in, const Convolution& convolution);
  Value relu(const Value& in);
  Value add(const Value& a, const Value& b);
  /// Bilinear, to twice the size.
  Value upsample(const Value& in);
  /// Names the output: 1 x H x W where there is one channel only.
  void finish(const Value& out);

  /// The file's bytes. To be called once, after finish().
  std::string bytes() const;
  double parameters() const { return parameters_; }
  double macs() const { return macs_; }

 private:
  std::string newName() { return "v" + std::to_string(++values_); }
  void addNode(const std::string& type, const std::vector<std::string>& inputs, const std::string& output,
               const std::string& attributes = "");
  void addWeights(const std::string& name, const std::vector<std::int64_t>& dims,
                  const std::vector<float>& values);

  OnnxShape input_;
  OnnxShape output_;
  int values_ = 0;
  std::string nodes_;
  std::string initializers_;
  double parameters_ = 0.0;
  double macs_ = 0.0;
};

}  // namespace frugal_nav::eval
