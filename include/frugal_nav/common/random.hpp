#pragma once

#include <cstdint>
#include <random>
#include <string_view>

namespace frugal_nav {

/// Seeded random numbers. Each consumer draws from its own named stream, so that adding a sensor or a draw in
/// one of them leaves the others' numbers as they were.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(mix(seed)) {}
  Random(std::uint64_t seed, std::string_view stream) : engine_(mix(seed ^ hash(stream))) {}

  /// Uniform in [low, high).
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11U) * 0x1.0p-53);
  }
  /// Gaussian of mean 0.
  double normal(double sigma) { return sigma * gauss_(engine_); }
  /// Uniform integer in [low, high], both included.
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }
  /// True with the given probability.
  bool chance(double probability) { return uniform(0.0, 1.0) < probability; }

 private:
  static std::uint64_t mix(std::uint64_t x) {  // splitmix64, so that neighbouring seeds give unlike streams
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31U);
  }
  static std::uint64_t hash(std::string_view text) {  // FNV-1a: the same on every platform
    std::uint64_t h = 0xcbf29ce484222325ULL;
    for (const char c : text) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
    return h;
  }

  std::mt19937_64 engine_;
  std::normal_distribution<double> gauss_{0.0, 1.0};
};

}  // namespace frugal_nav
