#pragma once

#include <cstdint>
#include <string>

namespace frugal_nav::eval {

/// What a network costs.
struct NetworkCost {
  double parameters = 0.0;
  double macs = 0.0;  ///< multiplications and additions of one image
};

/// Writes an ONNX network with the layers and shapes of MiDaS v2.1 small (an EfficientNet-Lite3 and its
/// decoder: 1x3x256x256 in, 1x256x256 out) and random weights, which cost the same time. For timing and for
/// tests: what it gives is no depth. Throws ConfigError when the file cannot be written.
NetworkCost writeMidasSizedNetwork(const std::string& path, std::uint64_t seed = 1);

}  // namespace frugal_nav::eval
