#include "marker_edges.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace frugal_nav::marker_detail {
namespace {

using Quad = std::array<Eigen::Vector2d, 4>;

constexpr double kEnds = 0.08;  // share of a side at each end that is left out: there the corner's blur is
constexpr double kReachCells =
    0.8;  // of a profile across an edge, each way, in cells: the code begins after one
constexpr double kShortestReach_px = 1.0;
constexpr double kLongestReach_px = 4.0;
constexpr double kStep_px = 0.5;
constexpr double kFarthestShift_px = 3.0;

/// Brightness between pixels; NaN outside of the image.
float lightAt(const cv::Mat& light, const Eigen::Vector2d& p) {
  const int column = static_cast<int>(std::floor(p.x()));
  const int row = static_cast<int>(std::floor(p.y()));
  if (column < 0 || row < 0 || column + 1 >= light.cols || row + 1 >= light.rows)
    return std::numeric_limits<float>::quiet_NaN();
  const auto fx = static_cast<float>(p.x() - column);
  const auto fy = static_cast<float>(p.y() - row);
  const float* above = light.ptr<float>(row) + column;
  const float* below = light.ptr<float>(row + 1) + column;
  return (1.0F - fy) * ((1.0F - fx) * above[0] + fx * above[1]) +
         fy * ((1.0F - fx) * below[0] + fx * below[1]);
}

/// How far outward of a point it turns from black to white: the middle of the squared slope.
std::optional<double> edgeOffset(const cv::Mat& light, const Eigen::Vector2d& p,
                                 const Eigen::Vector2d& outward, double reach_px) {
  double weight = 0.0;
  double sum = 0.0;
  for (double at = -reach_px; at + kStep_px <= reach_px + 1e-9; at += kStep_px) {
    const double rise = lightAt(light, p + (at + kStep_px) * outward) - lightAt(light, p + at * outward);
    if (!(rise > 0.0)) continue;  // NaN too
    weight += rise * rise;
    sum += rise * rise * (at + 0.5 * kStep_px);
  }
  if (weight == 0.0) return std::nullopt;
  return sum / weight;
}

struct Line {
  Eigen::Vector2d point;
  Eigen::Vector2d normal;
};

/// The line through a quad's edge from corner `i` to the next.
std::optional<Line> fitEdge(const cv::Mat& light, int cells, const Quad& quad, std::size_t i) {
  const Eigen::Vector2d from = quad[i];
  const Eigen::Vector2d side = quad[(i + 1) % 4] - from;
  const Eigen::Vector2d before = quad[(i + 3) % 4] - from;
  const double depth = 0.5 * (before.norm() + (quad[(i + 2) % 4] - quad[(i + 1) % 4]).norm());
  const double reach = std::clamp(kReachCells * depth / cells, kShortestReach_px, kLongestReach_px);
  Eigen::Vector2d outward = Eigen::Vector2d(side.y(), -side.x()).normalized();
  if (outward.dot(before) > 0.0) outward = -outward;

  const int samples = std::max(4, static_cast<int>((1.0 - 2.0 * kEnds) * side.norm()));
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int found = 0;
  for (int k = 0; k < samples; ++k) {
    const Eigen::Vector2d offset = (kEnds + (1.0 - 2.0 * kEnds) * (k + 0.5) / samples) * side;
    const std::optional<double> edge = edgeOffset(light, from + offset, outward, reach);
    if (!edge) continue;
    const Eigen::Vector2d p = offset + *edge * outward;  // from `from`, so that the squares keep their digits
    squares += p * p.transpose();
    sum += p;
    ++found;
  }
  if (found < 3) return std::nullopt;
  const Eigen::Vector2d centre = sum / found;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(squares / found - centre * centre.transpose());
  return Line{from + centre, axes.eigenvectors().col(0)};
}

/// Light by grey level (IEC 61966-2-1).
cv::Mat linearTable() {
  cv::Mat table(1, 256, CV_32FC1);
  for (int i = 0; i < 256; ++i) {
    const double srgb = i / 255.0;
    table.at<float>(i) =
        static_cast<float>(srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4));
  }
  return table;
}

std::optional<Quad> meetingPoints(const std::array<Line, 4>& lines) {
  Quad corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const Line& before = lines[(i + 3) % 4];
    const Line& after = lines[i];
    Eigen::Matrix2d normals;
    normals << before.normal.transpose(), after.normal.transpose();
    constexpr double kLeastTurn = 0.05;  // sine between the edges of a marker seen from the side
    if (std::abs(normals.determinant()) < kLeastTurn) return std::nullopt;
    corners[i] =
        normals.inverse() * Eigen::Vector2d(before.normal.dot(before.point), after.normal.dot(after.point));
  }
  return corners;
}

}  // namespace

cv::Mat linearLight(const cv::Mat& grey) {
  static const cv::Mat table = linearTable();
  cv::Mat light;
  cv::LUT(grey, table, light);
  return light;
}

bool fitEdges(const cv::Mat& light, int cells, Quad& corners) {
  Quad moved = corners;
  constexpr int kPasses = 2;  // the second one along the right edges
  for (int pass = 0; pass < kPasses; ++pass) {
    std::array<Line, 4> lines;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::optional<Line> line = fitEdge(light, cells, moved, i);
      if (!line) return false;
      lines[i] = *line;
    }
    const std::optional<Quad> met = meetingPoints(lines);
    if (!met) return false;
    for (std::size_t i = 0; i < 4; ++i) {
      if (!((*met)[i] - corners[i]).allFinite() || ((*met)[i] - corners[i]).norm() > kFarthestShift_px)
        return false;
    }
    moved = *met;
  }
  corners = moved;
  return true;
}

bool isClipped(const cv::Mat& light, int cells, const Quad& corners) {
  const Eigen::Vector2d centre = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  const double scale = 1.0 + 1.0 / cells;  // half a cell outside
  constexpr int kPoints = 8;               // along each side
  constexpr float kFull = 0.97F;
  int clipped = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (int k = 0; k < kPoints; ++k) {
      const double share = (k + 0.5) / kPoints;
      const Eigen::Vector2d p = (1.0 - share) * corners[i] + share * corners[(i + 1) % 4];
      if (lightAt(light, centre + scale * (p - centre)) > kFull) ++clipped;
    }
  }
  return clipped > 2 * kPoints;
}

}  // namespace frugal_nav::marker_detail
