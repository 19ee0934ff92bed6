#include <algorithm>
#include <cmath>
#include <numeric>

#include <frugal_nav/eval/statistics.hpp>

namespace frugal_nav::eval {

Interval wilsonInterval(int successes, int trials) {
  if (trials <= 0) return {};
  constexpr double kZ = 1.959963984540054;  // of the two-sided 95 % interval
  const double n = trials;
  const double p = successes / n;
  const double centre = (p + kZ * kZ / (2.0 * n)) / (1.0 + kZ * kZ / n);
  const double half = kZ / (1.0 + kZ * kZ / n) * std::sqrt(p * (1.0 - p) / n + kZ * kZ / (4.0 * n * n));
  return {std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

std::optional<double> mean(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::optional<double> rootMeanSquare(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  const double sum = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace frugal_nav::eval
