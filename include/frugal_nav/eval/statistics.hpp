#pragma once

#include <optional>
#include <vector>

namespace frugal_nav::eval {

/// Bounds of a probability.
struct Interval {
  double low = 0.0;
  double high = 1.0;
};

/// Wilson's score interval of a success rate at 95 % confidence (E. B. Wilson, JASA 22, 1927).
Interval wilsonInterval(int successes, int trials);

/// Arithmetic mean; nullopt of nothing.
std::optional<double> mean(const std::vector<double>& values);

/// Root of the mean square; nullopt of nothing.
std::optional<double> rootMeanSquare(const std::vector<double>& values);

}  // namespace frugal_nav::eval
