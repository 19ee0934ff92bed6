#pragma once

#include <cstddef>
#include <deque>
#include <optional>

namespace frugal_nav {

/// Wheel distance over visual distance, robust against wheels that slip: the median of the last baselines.
class VisualScale {
 public:
  /// A median with its standard deviation, from the median absolute deviation.
  struct Estimate {
    double scale = 1.0;
    double sigma = 0.0;
    int samples = 0;
  };

  explicit VisualScale(std::size_t samples) : capacity_(samples) {}

  /// One baseline; both distances must be positive [m].
  void add(double wheel_m, double visual_m);
  void clear() { ratios_.clear(); }
  /// nullopt before the first baseline.
  std::optional<Estimate> estimate() const;

 private:
  std::size_t capacity_;
  std::deque<double> ratios_;
};

}  // namespace frugal_nav
