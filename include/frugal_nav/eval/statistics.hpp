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

/// Outcome of a test: its statistic and the probability of one at least as large by chance.
struct TestResult {
  double statistic = 0.0;
  double p = 1.0;
};

/// Cochran's Q, the Friedman test for yes or no: whether the same trials (rows) succeed alike under several
/// conditions (columns). Nothing when the statistic does not exist: all columns alike in every trial, or
/// fewer than two conditions. Throws std::invalid_argument when rows differ in length.
std::optional<TestResult> cochranQ(const std::vector<std::vector<bool>>& trials);

/// Probability that a chi-squared variable exceeds a value.
double chiSquaredTail(double value, int degrees_of_freedom);

}  // namespace frugal_nav::eval
