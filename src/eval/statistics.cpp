#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

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

double chiSquaredTail(double value, int degrees_of_freedom) {
  // From one or two degrees of freedom, each further two add a term (Abramowitz and Stegun, 26.4.4, 26.4.5).
  const double half = 0.5 * value;
  const bool odd = degrees_of_freedom % 2 != 0;
  double tail = odd ? std::erfc(std::sqrt(half)) : std::exp(-half);
  double order = odd ? 0.5 : 1.0;
  for (int k = odd ? 1 : 2; k < degrees_of_freedom; k += 2, order += 1.0)
    tail += std::pow(half, order) * std::exp(-half) / std::tgamma(order + 1.0);
  return tail;
}

std::optional<TestResult> cochranQ(const std::vector<std::vector<bool>>& trials) {
  if (trials.empty() || trials.front().size() < 2) return std::nullopt;
  const std::size_t conditions = trials.front().size();
  std::vector<double> columns(conditions, 0.0);
  double sum = 0.0;
  double row_squares = 0.0;
  for (const std::vector<bool>& trial : trials) {
    if (trial.size() != conditions) throw std::invalid_argument("trials differ in their conditions");
    double row = 0.0;
    for (std::size_t k = 0; k < conditions; ++k) {
      columns[k] += trial[k] ? 1.0 : 0.0;
      row += trial[k] ? 1.0 : 0.0;
    }
    sum += row;
    row_squares += row * row;
  }
  const double column_squares = std::inner_product(columns.begin(), columns.end(), columns.begin(), 0.0);
  const auto k = static_cast<double>(conditions);
  const double denominator = k * sum - row_squares;
  if (denominator <= 0.0) return std::nullopt;
  TestResult result;
  result.statistic = (k - 1.0) * (k * column_squares - sum * sum) / denominator;
  result.p = chiSquaredTail(result.statistic, static_cast<int>(conditions) - 1);
  return result;
}

}  // namespace frugal_nav::eval
