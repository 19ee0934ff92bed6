#include "fast_noise.hpp"

#include <cmath>

namespace frugal_nav::sim {
namespace {

/// The standard normal distribution's quantile, by Newton's method from a near guess.
double quantile(double probability, double guess) {
  for (int i = 0; i < 20; ++i) {
    const double error = 0.5 * std::erfc(-guess * M_SQRT1_2) - probability;
    const double density = std::exp(-0.5 * guess * guess) / std::sqrt(2.0 * M_PI);
    guess -= error / density;
  }
  return guess;
}

}  // namespace

const std::array<float, FastNoise::kSize>& FastNoise::quantiles() {
  static const std::array<float, kSize> table = [] {
    std::array<double, kSize> values{};
    double squares = 0.0;
    double guess = 0.0;
    for (std::size_t i = kSize / 2; i < kSize; ++i) {  // from the middle outwards, each from its neighbour
      guess = quantile((static_cast<double>(i) + 0.5) / static_cast<double>(kSize), guess);
      values[i] = guess;
      values[kSize - 1 - i] = -guess;
      squares += 2.0 * guess * guess;
    }
    const double scale = std::sqrt(static_cast<double>(kSize) / squares);
    std::array<float, kSize> scaled{};
    for (std::size_t i = 0; i < kSize; ++i) scaled[i] = static_cast<float>(values[i] * scale);
    return scaled;
  }();
  return table;
}

}  // namespace frugal_nav::sim
