#include "visual_corners.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/features2d.hpp>

namespace frugal_nav {
namespace {

struct Corner {
  cv::Point2f pixel;
  float score = 0.0F;
};

/// Smaller eigenvalue of the gradient matrix of a 7x7 patch (Shi and Tomasi, CVPR 1994).
float shiTomasi(const cv::Mat& gray, int x, int y) {
  constexpr int kHalf = 3;
  if (x <= kHalf || y <= kHalf || x + kHalf + 1 >= gray.cols || y + kHalf + 1 >= gray.rows) return 0.0F;
  int xx = 0;
  int xy = 0;
  int yy = 0;
  for (int row = y - kHalf; row <= y + kHalf; ++row) {
    const unsigned char* above = gray.ptr(row - 1);
    const unsigned char* line = gray.ptr(row);
    const unsigned char* below = gray.ptr(row + 1);
    for (int column = x - kHalf; column <= x + kHalf; ++column) {
      const int dx = line[column + 1] - line[column - 1];
      const int dy = below[column] - above[column];
      xx += dx * dx;
      xy += dx * dy;
      yy += dy * dy;
    }
  }
  const auto sum = static_cast<float>(xx + yy);
  const auto difference = static_cast<float>(xx - yy);
  const auto mixed = static_cast<float>(xy);
  return 0.5F * (sum - std::sqrt(difference * difference + 4.0F * mixed * mixed));
}

/// Which pixels of an area lie near a feature (in squares, which are quick to fill).
class Taken {
 public:
  Taken(const cv::Rect& area, float radius_px)
      : origin_(area.tl()),
        radius_(std::max(1, cvRound(radius_px))),
        mask_(area.size(), CV_8U, cv::Scalar(0)) {}

  void add(const cv::Point2f& pixel) {
    const cv::Point centre = inside(pixel);
    const int side = 2 * radius_ + 1;
    const cv::Rect box =
        cv::Rect(centre.x - radius_, centre.y - radius_, side, side) & cv::Rect({0, 0}, mask_.size());
    if (!box.empty()) mask_(box).setTo(255);
  }
  bool holds(const cv::Point2f& pixel) const { return mask_.at<unsigned char>(inside(pixel)) != 0; }

 private:
  cv::Point inside(const cv::Point2f& pixel) const {
    return cv::Point(cvRound(pixel.x), cvRound(pixel.y)) - origin_;
  }

  cv::Point origin_;
  int radius_;
  cv::Mat mask_;
};

}  // namespace

std::vector<cv::Point2f> findCorners(const cv::Mat& gray, const cv::Rect& area,
                                     const std::vector<cv::Point2f>& taken, const CornerSearch& search) {
  std::vector<cv::KeyPoint> found;
  cv::FAST(gray(area), found, search.fast_threshold);
  // Half the threshold where there are few: a dim or even room.
  if (found.size() < 2 * static_cast<std::size_t>(search.wanted))
    cv::FAST(gray(area), found, std::max(3, search.fast_threshold / 2));

  const float cell = static_cast<float>(area.width) / static_cast<float>(search.grid_columns);
  const int rows = static_cast<int>(static_cast<float>(area.height) / cell) + 1;
  std::vector<std::vector<Corner>> cells(static_cast<std::size_t>(rows * search.grid_columns));
  const cv::Point2f origin(static_cast<float>(area.x), static_cast<float>(area.y));
  const auto cellOf = [&](const cv::Point2f& pixel) {
    const int column = std::min(search.grid_columns - 1, static_cast<int>((pixel.x - origin.x) / cell));
    return static_cast<std::size_t>(static_cast<int>((pixel.y - origin.y) / cell) * search.grid_columns +
                                    column);
  };
  Taken mask(area, search.min_distance_px);
  std::vector<int> held(cells.size(), 0);
  int missing = search.wanted;
  for (const cv::Point2f& pixel : taken) {
    mask.add(pixel);
    if (!area.contains(cv::Point(pixel))) continue;
    ++held[cellOf(pixel)];
    --missing;
  }
  for (const cv::KeyPoint& keypoint : found) {
    const cv::Point2f pixel = keypoint.pt + origin;
    const float score = shiTomasi(gray, cvRound(pixel.x), cvRound(pixel.y));
    if (score > 0.0F && !mask.holds(pixel)) cells[cellOf(pixel)].push_back({pixel, score});
  }
  for (auto& corners : cells) {
    std::stable_sort(corners.begin(), corners.end(),
                     [](const Corner& a, const Corner& b) { return a.score < b.score; });
  }
  // Round by round the cells with the fewest features get one more, their best one (the last in the list).
  std::vector<cv::Point2f> chosen;
  for (int level = 0; missing > 0; ++level) {
    bool is_exhausted = true;
    for (std::size_t i = 0; i < cells.size() && missing > 0; ++i) {
      is_exhausted = is_exhausted && cells[i].empty();
      if (held[i] > level) continue;
      while (!cells[i].empty() && mask.holds(cells[i].back().pixel)) cells[i].pop_back();
      if (cells[i].empty()) continue;
      chosen.push_back(cells[i].back().pixel);
      mask.add(chosen.back());
      cells[i].pop_back();
      ++held[i];
      --missing;
    }
    if (is_exhausted) break;
  }
  return chosen;
}

}  // namespace frugal_nav
