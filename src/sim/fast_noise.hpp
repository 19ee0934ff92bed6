#pragma once

#include <array>
#include <cstdint>

namespace frugal_nav::sim {

/// Gaussian noise for images: four values a random word, looked up in a table of quantiles, which costs less
/// than the ray it disturbs. One stream for each image row, so that the threads' order does not matter.
class FastNoise {
 public:
  FastNoise(std::uint64_t seed, std::uint64_t frame, std::uint64_t row)
      : state_(mix(mix(mix(seed) ^ frame) ^ row) | 1U), table_(quantiles()) {}

  /// Gaussian of mean 0 and variance 1, cut off at 3.7.
  float gauss() {
    if (left_ == 0) refill();
    --left_;
    const float value = table_[word_ & (kSize - 1)];
    word_ >>= 16U;
    return value;
  }

 private:
  static constexpr std::size_t kSize = 4096;

  static const std::array<float, kSize>& quantiles();
  static std::uint64_t mix(std::uint64_t x) {  // splitmix64
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31U);
  }
  void refill() {  // xorshift64*
    state_ ^= state_ >> 12U;
    state_ ^= state_ << 25U;
    state_ ^= state_ >> 27U;
    word_ = state_ * 0x2545f4914f6cdd1dULL;
    word_ ^= word_ >> 32U;  // the multiplier leaves the low bits weak
    left_ = 4;
  }

  std::uint64_t state_;
  std::uint64_t word_ = 0;
  int left_ = 0;
  const std::array<float, kSize>& table_;
};

}  // namespace frugal_nav::sim
