#include <algorithm>
#include <cmath>
#include <numeric>

#include <frugal_nav/perception/column_profile.hpp>

namespace frugal_nav {

ColumnProfile profileColumns(const cv::Mat& inverse, const cv::Mat& floor, const ViewRays& rays,
                             double horizon_margin_rad) {
  ColumnProfile profile;
  for (int column = 0; column < inverse.cols; ++column) {
    float nearest = 0.0F;
    bool has_valid = false;
    bool is_unbroken = true;
    for (int row = rays.firstRowBelowHorizon(column, horizon_margin_rad); row < inverse.rows; ++row) {
      if (floor.at<uchar>(row, column) != 0) continue;
      is_unbroken = false;
      const float z = inverse.at<float>(row, column);
      if (!std::isfinite(z)) continue;
      has_valid = true;
      nearest = std::max(nearest, z);
    }
    profile.nearest.push_back(nearest);
    profile.states.push_back(has_valid     ? ColumnProfile::State::kSeen
                             : is_unbroken ? ColumnProfile::State::kOpen
                                           : ColumnProfile::State::kUnknown);
  }
  return profile;
}

std::vector<float> relativeDepths(const ColumnProfile& profile, float least_inverse, float clip) {
  std::vector<float> depths;
  for (std::size_t i = 0; i < profile.states.size(); ++i) {
    const float seen = std::min(clip, 1.0F / std::max(profile.nearest[i], least_inverse));
    const ColumnProfile::State state = profile.states[i];
    depths.push_back(state == ColumnProfile::State::kSeen   ? seen
                     : state == ColumnProfile::State::kOpen ? clip
                                                            : 0.0F);
  }
  return depths;
}

std::vector<char> thresholdAtMean(const std::vector<float>& depths, float clip) {
  const double sum = std::accumulate(depths.begin(), depths.end(), 0.0);
  const double mean = depths.empty() ? 0.0 : sum / static_cast<double>(depths.size());
  std::vector<char> near;
  for (const float depth : depths) near.push_back(static_cast<double>(depth) > mean || depth >= clip ? 0 : 1);
  return near;
}

void flipShortRuns(int noise_length, std::vector<char>& near) {
  for (auto begin = near.begin(); begin != near.end();) {
    const auto end = std::find_if(begin, near.end(), [begin](char bit) { return bit != *begin; });
    if (*begin == 1 && end - begin < noise_length) std::fill(begin, end, char{0});
    begin = end;
  }
}

std::optional<ColumnRun> longestOpenRun(const std::vector<char>& near) {
  std::optional<ColumnRun> longest;
  for (std::size_t begin = 0; begin < near.size();) {
    std::size_t end = begin;
    while (end < near.size() && near[end] == near[begin]) ++end;
    const ColumnRun run{static_cast<int>(begin), static_cast<int>(end) - 1};
    if (near[begin] == 0 && (!longest || run.length() > longest->length())) longest = run;
    begin = end;
  }
  return longest;
}

int blockOf(double column, int width) {
  constexpr int kBlocks = 5;
  const int block = static_cast<int>(std::floor((column + 0.5) * kBlocks / width));
  return std::clamp(block, 0, kBlocks - 1) - kBlocks / 2;
}

}  // namespace frugal_nav
