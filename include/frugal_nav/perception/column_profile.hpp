#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <frugal_nav/perception/view_rays.hpp>

namespace frugal_nav {

/// The nearest of each image column (paper 000, stage 6).
struct ColumnProfile {
  enum class State {
    kSeen,    ///< something stands there
    kOpen,    ///< nothing but floor, unbroken from the bottom to the horizon
    kUnknown  ///< nothing, and the floor is broken: taken as near
  };
  std::vector<State> states;
  std::vector<float> nearest;  ///< largest relative inverse depth of the valid pixels; 0 where there are none
};

/// A run of columns, both ends included.
struct ColumnRun {
  int first = 0;
  int last = 0;
  int length() const { return last - first + 1; }
};

/// Largest inverse depth of each column over the pixels that are neither floor nor above the horizon.
/// `inverse` is CV_32FC1 of the grid's size, `floor` CV_8UC1 likewise (255 floor).
ColumnProfile profileColumns(const cv::Mat& inverse, const cv::Mat& floor, const ViewRays& rays,
                             double horizon_margin_rad);

/// Relative depth of each column, 1 / max(z, least_inverse) and at most `clip`; open columns have `clip`,
/// unknown ones 0.
std::vector<float> relativeDepths(const ColumnProfile& profile, float least_inverse, float clip);

/// 0 where the depth is more than the mean of all (open), 1 else (near). With `clip` in all columns, all are
/// open.
std::vector<char> thresholdAtMean(const std::vector<float>& depths, float clip);

/// Runs of 1 shorter than `noise_length` become 0.
void flipShortRuns(int noise_length, std::vector<char>& near);

/// The longest run of 0, the first of several; nothing when there is none.
std::optional<ColumnRun> longestOpenRun(const std::vector<char>& near);

/// Which of five equal vertical segments holds a place: -2 (left) to 2 (right).
int blockOf(double column, int width);

}  // namespace frugal_nav
