#include <algorithm>
#include <cmath>
#include <vector>

#include <frugal_nav/odometry/visual_scale.hpp>

namespace frugal_nav {
namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

}  // namespace

void VisualScale::add(double wheel_m, double visual_m) {
  ratios_.push_back(wheel_m / visual_m);
  if (ratios_.size() > capacity_) ratios_.pop_front();
}

std::optional<VisualScale::Estimate> VisualScale::estimate() const {
  if (ratios_.empty()) return std::nullopt;
  Estimate out;
  out.samples = static_cast<int>(ratios_.size());
  out.scale = median({ratios_.begin(), ratios_.end()});
  std::vector<double> deviations;
  for (const double ratio : ratios_) deviations.push_back(std::abs(ratio - out.scale));
  // 1.4826 makes the median absolute deviation a standard deviation, 1.2533 is the median's loss against the
  // mean. A single baseline is taken to be good to 10 %, any to 2 %.
  const double spread = out.samples < 3 ? 0.1 : std::max(0.02, 1.4826 * median(deviations) / out.scale);
  out.sigma = 1.2533 * out.scale * spread / std::sqrt(out.samples);
  return out;
}

}  // namespace frugal_nav
