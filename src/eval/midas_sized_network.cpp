#include "onnx_writer.hpp"

#include <cmath>
#include <fstream>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/eval/midas_sized_network.hpp>

namespace frugal_nav::eval {
namespace {

using Value = OnnxWriter::Value;

constexpr std::int64_t kSide_px = 256;

/// A stage of EfficientNet-Lite3 (github.com/tensorflow/tpu, efficientnet/lite): alike blocks, the first of
/// which strides.
struct Stage {
  int blocks;
  std::int64_t kernel;
  std::int64_t stride;
  std::int64_t expand;
  std::int64_t channels;
};
constexpr Stage kStages[] = {{1, 3, 1, 1, 24},  {3, 3, 2, 6, 32},  {3, 5, 2, 6, 48}, {5, 3, 2, 6, 96},
                             {5, 5, 1, 6, 136}, {6, 5, 2, 6, 232}, {1, 3, 1, 6, 384}};

class Builder {
 public:
  explicit Builder(std::uint64_t seed) : random_(seed, "network"), writer_({3, kSide_px, kSide_px}) {}

  const OnnxWriter& build() {
    Value x = writer_.relu(convolve(writer_.input(), {32, 3, 2, false}));
    std::vector<Value> skips;
    for (std::size_t stage = 0; stage < std::size(kStages); ++stage) {
      for (int block = 0; block < kStages[stage].blocks; ++block) x = bottleneck(x, kStages[stage], block);
      if (stage == 1 || stage == 2 || stage == 4 || stage == 6) skips.push_back(x);
    }
    // The decoder: each level as wide as its name says, doubled from level to level.
    Value path = refine(convolve(skips[3], {512}), 256);
    path = refine(writer_.add(path, unit(convolve(skips[2], {256}))), 128);
    path = refine(writer_.add(path, unit(convolve(skips[1], {128}))), 64);
    path = refine(writer_.add(path, unit(convolve(skips[0], {64}))), 64);
    path = writer_.upsample(convolve(path, {32}));
    path = writer_.relu(convolve(path, {32}));
    writer_.finish(writer_.relu(convolve(path, {1, 1, 1, false})));
    return writer_;
  }

 private:
  Value convolve(const Value& in, const OnnxWriter::Convolution& convolution) {
    std::vector<float> weights(static_cast<std::size_t>(OnnxWriter::weightsOf(in, convolution)));
    // Keeps the activations' size from layer to layer (He et al., ICCV 2015).
    const double fan_in = static_cast<double>(weights.size()) / static_cast<double>(convolution.out_channels);
    const double sigma = std::sqrt(2.0 / fan_in);
    for (float& weight : weights) weight = static_cast<float>(random_.normal(sigma));
    return writer_.convolve(in, convolution, weights);
  }

  Value bottleneck(const Value& in, const Stage& stage, int block) {
    const std::int64_t wide = in.shape.channels * stage.expand;
    const std::int64_t stride = block == 0 ? stage.stride : 1;
    Value x = stage.expand == 1 ? in : writer_.relu(convolve(in, {wide, 1, 1, false}));
    x = writer_.relu(convolve(x, {wide, stage.kernel, stride, true}));
    x = convolve(x, {stage.channels, 1, 1, false});
    return block == 0 ? x : writer_.add(in, x);
  }

  /// A residual unit of two convolutions.
  Value unit(const Value& in) {
    const std::int64_t channels = in.shape.channels;
    const Value x = writer_.relu(convolve(writer_.relu(in), {channels}));
    return writer_.add(in, convolve(x, {channels}));
  }

  Value refine(const Value& in, std::int64_t channels) {
    return convolve(writer_.upsample(unit(in)), {channels, 1, 1, false});
  }

  Random random_;
  OnnxWriter writer_;
};

}  // namespace

NetworkCost writeMidasSizedNetwork(const std::string& path, std::uint64_t seed) {
  Builder builder(seed);
  const OnnxWriter& network = builder.build();
  const std::string bytes = network.bytes();
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) throw ConfigError("cannot write " + path);
  return {network.parameters(), network.macs()};
}

}  // namespace frugal_nav::eval
