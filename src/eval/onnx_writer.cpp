#include "onnx_writer.hpp"

#include <cstring>

namespace frugal_nav::eval {
namespace {

// Protocol Buffers' wire format (developers.google.com/protocol-buffers/docs/encoding), and the field numbers
// of onnx.proto.

std::string varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 0x80U; value >>= 7U) bytes.push_back(static_cast<char>((value & 0x7fU) | 0x80U));
  bytes.push_back(static_cast<char>(value));
  return bytes;
}

std::string number(unsigned field, std::int64_t value) {
  return varint(field << 3U) + varint(static_cast<std::uint64_t>(value));
}

std::string text(unsigned field, const std::string& bytes) {
  return varint((field << 3U) | 2U) + varint(bytes.size()) + bytes;
}

std::string integers(const std::string& name, const std::vector<std::int64_t>& values) {
  constexpr std::int64_t kInts = 7;
  std::string attribute = text(1, name);
  for (const std::int64_t value : values) attribute += number(8, value);
  return text(5, attribute + number(20, kInts));
}

std::string integer(const std::string& name, std::int64_t value) {
  constexpr std::int64_t kInt = 2;
  return text(5, text(1, name) + number(3, value) + number(20, kInt));
}

std::string word(const std::string& name, const std::string& value) {
  constexpr std::int64_t kString = 3;
  return text(5, text(1, name) + text(4, value) + number(20, kString));
}

std::string valueInfo(const std::string& name, const std::vector<std::int64_t>& dims) {
  constexpr std::int64_t kFloat = 1;
  std::string shape;
  for (const std::int64_t dim : dims) shape += text(1, number(1, dim));
  return text(1, name) + text(2, text(1, number(1, kFloat) + text(2, shape)));
}

}  // namespace

OnnxWriter::OnnxWriter(const OnnxShape& input) : input_(input) {
  addWeights("no_region", {0}, {});
  addWeights("twice", {4}, {1.0F, 1.0F, 2.0F, 2.0F});
}

void OnnxWriter::addNode(const std::string& type, const std::vector<std::string>& inputs,
                         const std::string& output, const std::string& attributes) {
  std::string node;
  for (const std::string& input : inputs) node += text(1, input);
  node += text(2, output) + text(3, "make_" + output) + text(4, type) + attributes;
  nodes_ += text(1, node);
}

void OnnxWriter::addWeights(const std::string& name, const std::vector<std::int64_t>& dims,
                            const std::vector<float>& values) {
  constexpr std::int64_t kFloat = 1;
  std::string tensor;
  for (const std::int64_t dim : dims) tensor += number(1, dim);
  std::string raw(values.size() * sizeof(float), '\0');
  if (!values.empty()) std::memcpy(raw.data(), values.data(), raw.size());
  initializers_ += text(5, tensor + number(2, kFloat) + text(8, name) + text(9, raw));
}

std::int64_t OnnxWriter::weightsOf(const Value& in, const Convolution& convolution) {
  const std::int64_t in_channels = convolution.depthwise ? 1 : in.shape.channels;
  return convolution.out_channels * in_channels * convolution.kernel * convolution.kernel;
}

OnnxWriter::Value OnnxWriter::convolve(const Value& in, const Convolution& convolution,
                                       const std::vector<float>& weights) {
  const std::int64_t k = convolution.kernel;
  const Value out{newName(),
                  {convolution.out_channels, (in.shape.height + convolution.stride - 1) / convolution.stride,
                   (in.shape.width + convolution.stride - 1) / convolution.stride}};
  const std::string kernel = "w_" + out.name;
  const std::string bias = "b_" + out.name;
  const std::int64_t groups = convolution.depthwise ? in.shape.channels : 1;
  addWeights(kernel, {convolution.out_channels, in.shape.channels / groups, k, k}, weights);
  addWeights(bias, {convolution.out_channels},
             std::vector<float>(static_cast<std::size_t>(convolution.out_channels), 0.0F));
  const std::int64_t pad = k / 2;
  addNode("Conv", {in.name, kernel, bias}, out.name,
          integers("kernel_shape", {k, k}) + integers("strides", {convolution.stride, convolution.stride}) +
              integers("pads", {pad, pad, pad, pad}) + integer("group", groups));
  const auto count = static_cast<double>(weightsOf(in, convolution));
  parameters_ += count + static_cast<double>(convolution.out_channels);
  macs_ += count * static_cast<double>(out.shape.height * out.shape.width);
  return out;
}

OnnxWriter::Value OnnxWriter::relu(const Value& in) {
  const Value out{newName(), in.shape};
  addNode("Relu", {in.name}, out.name);
  return out;
}

OnnxWriter::Value OnnxWriter::add(const Value& a, const Value& b) {
  const Value out{newName(), a.shape};
  addNode("Add", {a.name, b.name}, out.name);
  return out;
}

OnnxWriter::Value OnnxWriter::upsample(const Value& in) {
  const Value out{newName(), {in.shape.channels, 2 * in.shape.height, 2 * in.shape.width}};
  addNode("Resize", {in.name, "no_region", "twice"}, out.name,
          word("mode", "linear") + word("coordinate_transformation_mode", "half_pixel"));
  return out;
}

void OnnxWriter::finish(const Value& out) {
  output_ = out.shape;
  if (out.shape.channels == 1) {
    addNode("Squeeze", {out.name}, "output", integers("axes", {1}));
  } else {
    addNode("Identity", {out.name}, "output");
  }
}

std::string OnnxWriter::bytes() const {
  std::vector<std::int64_t> out{1, output_.channels, output_.height, output_.width};
  if (output_.channels == 1) out.erase(out.begin() + 1);
  const std::string graph = nodes_ + text(2, "network") + initializers_ +
                            text(11, valueInfo("input", {1, input_.channels, input_.height, input_.width})) +
                            text(12, valueInfo("output", out));
  constexpr std::int64_t kIrVersion = 6;
  constexpr std::int64_t kOpset = 11;
  return number(1, kIrVersion) + text(8, text(1, "") + number(2, kOpset)) + text(7, graph);
}

}  // namespace frugal_nav::eval
