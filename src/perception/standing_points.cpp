#include "standing_points.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

namespace frugal_nav {
namespace {

constexpr double kSure = 5.0;  // evidence of a network that is as sure as one is ever taken to be

struct Height {
  double value_m;
  double sigma_m;
};

/// Height of a point over the floor; nullopt outside the grid.
std::optional<Height> heightOf(const DepthAnchor& point, const ViewRays& rays) {
  const cv::Point cell(cvRound(point.cell.x), cvRound(point.cell.y));
  if (!cv::Rect(cv::Point(), rays.grid()).contains(cell)) return std::nullopt;
  const double rise = static_cast<double>(rays.ray(cell.y, cell.x).z()) / point.inverse_depth_pm;
  return Height{rays.cameraHeight_m() + rise, point.relative_sigma * std::abs(rise)};
}

/// Inverse depth of the points about one that lie as far: of single ones the nearest would tell, which errs
/// most.
double settled(const DepthAnchor& point, const std::vector<DepthAnchor>& points) {
  constexpr float kReach = 10.0F;  // cells
  std::vector<double> alike;
  for (const DepthAnchor& other : points) {
    if (std::abs(other.cell.x - point.cell.x) <= kReach && std::abs(other.cell.y - point.cell.y) <= kReach &&
        isAsFar(point, other))
      alike.push_back(other.inverse_depth_pm);
  }
  const auto middle = alike.begin() + static_cast<std::ptrdiff_t>(alike.size() / 2);
  std::nth_element(alike.begin(), middle, alike.end());
  return *middle;
}

/// Points that surely lie over the floor, and low enough for the robot; from left to right.
std::vector<DepthAnchor> pointsOverFloor(const std::vector<DepthAnchor>& points, const ViewRays& rays,
                                         double max_height_m) {
  constexpr double kLeastHeight_m = 0.05;
  std::vector<DepthAnchor> over;
  for (const DepthAnchor& point : points) {
    const std::optional<Height> height = heightOf(point, rays);
    const bool is_over =
        height && height->value_m - 2.0 * height->sigma_m > kLeastHeight_m && height->value_m < max_height_m;
    if (!is_over) continue;
    over.push_back(point);
    over.back().inverse_depth_pm = settled(point, points);
  }
  std::sort(over.begin(), over.end(),
            [](const DepthAnchor& a, const DepthAnchor& b) { return a.cell.x < b.cell.x; });
  return over;
}

/// Marks the row from which on something stands, in the columns from one point to another.
void markTop(const DepthAnchor& left, const DepthAnchor& right, cv::Mat& standing) {
  const auto inverse = static_cast<float>(0.5 * (left.inverse_depth_pm + right.inverse_depth_pm));
  const int row = cvRound(std::max(left.cell.y, right.cell.y));
  for (int column = cvRound(left.cell.x); column <= cvRound(right.cell.x); ++column) {
    float& cell = standing.at<float>(row, column);
    cell = std::max(cell, inverse);
  }
}

/// Carries the marks down to where the floor is at their depth; of several the nearest.
void fillDown(const ViewRays& rays, cv::Mat& standing) {
  for (int column = 0; column < standing.cols; ++column) {
    float nearest = 0.0F;
    for (int row = 0; row < standing.rows; ++row) {
      float& cell = standing.at<float>(row, column);
      nearest = std::max(nearest, cell);
      cell = rays.inverseFloorDepth(row, column) <= nearest ? nearest : 0.0F;
    }
  }
}

}  // namespace

bool isAsFar(const DepthAnchor& a, const DepthAnchor& b) {
  constexpr double kSameDepth = 0.1;  // as a share of it
  return std::abs(a.inverse_depth_pm / b.inverse_depth_pm - 1.0) <= kSameDepth;
}

bool agrees(const std::vector<DepthAnchor>& points, const cv::Mat& expected_pm) {
  constexpr double kMostOff = 0.25;  // median, logarithm: twice what the network errs by
  const cv::Rect grid(cv::Point(), expected_pm.size());
  std::vector<double> off;
  for (const DepthAnchor& point : points) {
    const cv::Point cell(cvRound(point.cell.x), cvRound(point.cell.y));
    if (!grid.contains(cell)) continue;
    const auto expected = static_cast<double>(expected_pm.at<float>(cell));
    off.push_back(std::abs(std::log(point.inverse_depth_pm / expected)));
  }
  if (off.empty()) return false;
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  return *middle < kMostOff;
}

void distrust(std::vector<DepthAnchor>& points) {
  for (DepthAnchor& point : points) point.unseen_gate = 0.0;
}

std::vector<DepthAnchor> agreedOn(const std::vector<DepthAnchor>& points) {
  std::vector<DepthAnchor> agreed;
  std::copy_if(points.begin(), points.end(), std::back_inserter(agreed),
               [](const DepthAnchor& point) { return point.unseen_gate > 0.0; });
  return agreed;
}

cv::Mat findStanding(const std::vector<DepthAnchor>& points, const ViewRays& rays, double max_height_m) {
  constexpr double kReach_m = 0.25;  // the robot does not fit between things nearer to each other
  const double cells_per_rad = rays.grid().width * rays.camera().fx / rays.camera().width_px;
  cv::Mat standing = cv::Mat::zeros(rays.grid(), CV_32FC1);
  const std::vector<DepthAnchor> over = pointsOverFloor(points, rays, max_height_m);
  for (std::size_t i = 0; i < over.size(); ++i) {
    const double last_column = over[i].cell.x + kReach_m * over[i].inverse_depth_pm * cells_per_rad;
    for (std::size_t k = i + 1; k < over.size() && over[k].cell.x <= last_column; ++k) {
      if (isAsFar(over[i], over[k])) markTop(over[i], over[k], standing);
    }
  }
  fillDown(rays, standing);
  return standing;
}

void denyFloor(const cv::Mat& standing, cv::Mat& evidence) {
  evidence.setTo(-kSure, (standing > 0.0) & (evidence > -kSure));
}

void confirmFloor(const std::vector<DepthAnchor>& points, const ViewRays& rays, cv::Mat& evidence) {
  constexpr double kFlat_m = 0.05;
  const cv::Rect grid(cv::Point(), evidence.size());
  for (const DepthAnchor& point : points) {
    const std::optional<Height> height = heightOf(point, rays);
    const bool is_flat = height && std::abs(height->value_m) + height->sigma_m < kFlat_m;
    if (!is_flat) continue;
    cv::Mat around = evidence(cv::Rect(cvRound(point.cell.x) - 1, cvRound(point.cell.y) - 1, 3, 3) & grid);
    around.setTo(kSure, around < kSure);
  }
}

std::vector<DepthAnchor> standingAnchors(const cv::Mat& standing) {
  constexpr int kStep = 3;
  constexpr double kLean = 0.05;  // as a share of the distance
  std::vector<DepthAnchor> anchors;
  for (int row = 0; row < standing.rows; row += kStep) {
    for (int column = 0; column < standing.cols; column += kStep) {
      const float inverse = standing.at<float>(row, column);
      const cv::Point2f cell(static_cast<float>(column), static_cast<float>(row));
      if (inverse > 0.0F)
        anchors.push_back({cell, static_cast<double>(inverse), kLean, kVoGate, kUnseenGate});
    }
  }
  return anchors;
}

}  // namespace frugal_nav
