#include "metric_cues.hpp"

#include "standing_points.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace frugal_nav {
namespace {

constexpr double kNearest_m = 0.1;
// Nearer points of visual odometry are wrong matches: nothing gets there unseen.
constexpr double kNearestPoint_m = 0.35;
constexpr double kFarthest_m = 20.0;
// How far a fitted depth may be off (logarithm).
constexpr double kContactGate = 0.6;

/// The value of the cell that holds a place.
std::optional<float> sampleAt(const cv::Mat& map, const Eigen::Vector2d& cell) {
  const int column = cvRound(cell.x());
  const int row = cvRound(cell.y());
  if (column < 0 || row < 0 || column >= map.cols || row >= map.rows) return std::nullopt;
  return map.at<float>(row, column);
}

/// Depth of a place in odom along the optical axis of the present camera.
double depthOf(const Eigen::Vector3d& p_odom, const DepthView& view) {
  const Eigen::Vector2d p_base = view.odom_from_base.inverse() * Eigen::Vector2d(p_odom.head<2>());
  return (view.base_from_optical.inverse() * Eigen::Vector3d(p_base.x(), p_base.y(), p_odom.z())).z();
}

/// Where the middle of the goal's head lies in the grid.
std::optional<Eigen::Vector2d> cellOf(const KnownGoal& goal, const DepthView& view, const ViewRays& rays) {
  if (goal.box_px.area() > 0.0) {
    const cv::Point2d middle = 0.5 * (goal.box_px.tl() + goal.box_px.br());
    return rays.toGrid({middle.x - 0.5, middle.y - 0.5});
  }
  const Eigen::Vector2d p = view.odom_from_base.inverse() * goal.p_odom;
  const auto pixel = rays.camera().project(view.base_from_optical.inverse() *
                                           Eigen::Vector3d(p.x(), p.y(), goal.above_floor_m));
  if (!pixel) return std::nullopt;
  return rays.toGrid(*pixel);
}

struct KnownDepth {
  Eigen::Vector2d cell;
  double depth_m;
  double sigma_m;
};

std::vector<KnownDepth> voDepths(const DepthView& view, const ViewRays& rays, double scale_sigma) {
  std::vector<KnownDepth> known;
  for (const MetricPoint& point : view.points) {
    const double depth = depthOf(point.p_odom, view);
    if (!(depth > kNearestPoint_m) || !(depth < kFarthest_m) || !(point.sigma_m >= 0.0)) continue;
    const double sigma = std::hypot(point.sigma_m, scale_sigma * depth);
    constexpr double kMostUnsure = 0.5;
    if (!(sigma < kMostUnsure * depth)) continue;
    const auto x = static_cast<double>(point.pixel.x);
    const auto y = static_cast<double>(point.pixel.y);
    known.push_back({rays.toGrid({x, y}), depth, sigma});
  }
  return known;
}

/// How many points near one in the grid lie at its depth, itself among them.
int alikeNear(const DepthAnchor& anchor, const std::vector<DepthAnchor>& points) {
  constexpr float kReach = 10.0F;
  return static_cast<int>(std::count_if(points.begin(), points.end(), [&anchor](const DepthAnchor& other) {
    return std::abs(other.cell.x - anchor.cell.x) <= kReach &&
           std::abs(other.cell.y - anchor.cell.y) <= kReach && isAsFar(anchor, other);
  }));
}

/// Whether points on the thing that stands in a column say that its foot is elsewhere. `fitted` (1/m) tells
/// what is one thing.
bool isContradicted(int column, const FloorContact& contact, const std::vector<DepthAnchor>& points,
                    const cv::Mat& fitted) {
  constexpr float kReach = 4.0F;       // columns
  constexpr double kSameThing = 0.15;  // of the fitted depths (logarithm)
  constexpr double kElsewhere = 0.06;  // of the known ones
  constexpr int kLeast = 3;
  const cv::Rect grid(cv::Point(), fitted.size());
  const cv::Point foot(column, std::max(0, contact.row - 2));
  int here = 0;
  int elsewhere = 0;
  for (const DepthAnchor& point : points) {
    const cv::Point cell(cvRound(point.cell.x), cvRound(point.cell.y));
    if (std::abs(point.cell.x - static_cast<float>(column)) > kReach || cell.y >= contact.row) continue;
    if (!grid.contains(cell)) continue;
    const auto ratio = static_cast<double>(fitted.at<float>(cell) / fitted.at<float>(foot));
    if (std::abs(std::log(ratio)) > kSameThing) continue;
    ++(std::abs(std::log(point.inverse_depth_pm * contact.depth_m)) > kElsewhere ? elsewhere : here);
  }
  return elsewhere >= kLeast && elsewhere > 2 * here;
}

/// Whether a cell and the one below it have much the same colour, as within one surface.
bool isAlike(const cv::Mat& bgr, int row, int column, int most) {
  const auto& upper = bgr.at<cv::Vec3b>(row, column);
  const auto& lower = bgr.at<cv::Vec3b>(row + 1, column);
  int off = 0;
  for (int c = 0; c < 3; ++c) off += std::abs(static_cast<int>(upper[c]) - static_cast<int>(lower[c]));
  return off <= most;
}

}  // namespace

std::vector<MetricSample> voSamples(const DepthView& view, const ViewRays& rays, const cv::Mat& inverse,
                                    double scale_sigma) {
  std::vector<MetricSample> samples;
  for (const KnownDepth& known : voDepths(view, rays, scale_sigma)) {
    const std::optional<float> z = sampleAt(inverse, known.cell);
    if (!z) continue;
    samples.push_back({static_cast<double>(*z), 1.0 / known.depth_m,
                       known.sigma_m / (known.depth_m * known.depth_m), Cue::kVo});
  }
  return samples;
}

std::vector<MetricSample> floorSamples(const cv::Mat& floor_mask, const ViewRays& rays,
                                       const cv::Mat& inverse, double pitch_sigma_rad) {
  constexpr int kStep = 4;
  constexpr double kFarthestFloor_m = 6.0;
  const double sigma = pitch_sigma_rad / rays.cameraHeight_m();
  std::vector<MetricSample> samples;
  for (int row = inverse.rows - 1; row >= 0; row -= kStep) {
    for (int column = kStep / 2; column < inverse.cols; column += kStep) {
      const auto floor_pm = static_cast<double>(rays.inverseFloorDepth(row, column));
      if (floor_mask.at<uchar>(row, column) == 0 || !(floor_pm * kFarthestFloor_m > 1.0)) continue;
      samples.push_back({static_cast<double>(inverse.at<float>(row, column)), floor_pm, sigma, Cue::kFloor});
    }
  }
  return samples;
}

std::vector<MetricSample> goalSamples(const DepthView& view, const ViewRays& rays, const cv::Mat& inverse,
                                      double least_relative_sigma) {
  if (!view.goal || !view.goal->seen) return {};
  const KnownGoal& goal = *view.goal;
  const double depth = depthOf({goal.p_odom.x(), goal.p_odom.y(), goal.above_floor_m}, view);
  const std::optional<Eigen::Vector2d> cell = cellOf(goal, view, rays);
  if (!cell) return {};
  const std::optional<float> z = sampleAt(inverse, *cell);
  const double sigma =
      std::max(least_relative_sigma * depth, std::sqrt(std::max(0.0, 0.5 * goal.covariance_m2.trace())));
  if (!z || !(depth > kNearest_m) || !std::isfinite(sigma)) return {};
  return {{static_cast<double>(*z), 1.0 / depth, sigma / (depth * depth), Cue::kGoal}};
}

std::vector<DepthAnchor> voAnchors(const DepthView& view, const ViewRays& rays, double scale_sigma) {
  std::vector<DepthAnchor> anchors;
  for (const KnownDepth& known : voDepths(view, rays, scale_sigma)) {
    anchors.push_back({cv::Point2f(static_cast<float>(known.cell.x()), static_cast<float>(known.cell.y())),
                       1.0 / known.depth_m, known.sigma_m / known.depth_m, kVoGate});
  }
  for (DepthAnchor& anchor : anchors) {
    constexpr int kLeastAlike = 4;
    if (alikeNear(anchor, anchors) >= kLeastAlike) anchor.unseen_gate = kUnseenGate;
  }
  return anchors;
}

std::vector<DepthAnchor> contactAnchors(const std::vector<FloorContact>& contacts, const ViewRays& rays,
                                        const cv::Mat& small_bgr, const std::vector<DepthAnchor>& points,
                                        const cv::Mat& fitted) {
  constexpr float kFoot_m = 0.15F;
  constexpr float kHighest_m = 0.6F;
  constexpr int kSkip = 1;           // the lowest row is half floor
  constexpr int kSameColour = 24;    // sum over the channels, from row to row
  constexpr double kLeanPerM = 0.2;  // what a thing may lean, as a share of its distance
  std::vector<DepthAnchor> anchors;
  for (int column = 0; column < rays.grid().width; ++column) {
    const FloorContact& contact = contacts[static_cast<std::size_t>(column)];
    if (contact.state != FloorContact::State::kContact) continue;
    if (isContradicted(column, contact, points, fitted)) continue;
    const int first = contact.row - kSkip;
    for (int row = first; row >= 0; --row) {
      const float depth = rays.uprightDepth(row, contact.row, column, static_cast<float>(contact.depth_m));
      const float height_m = rays.heightAt(row, column, depth);
      const bool is_foot = row >= contact.row - 6 || height_m <= kFoot_m;
      if (!is_foot && (height_m > kHighest_m || !isAlike(small_bgr, row, column, kSameColour))) break;
      if ((first - row) % (is_foot ? 2 : 4) != 0) continue;
      const double sigma = std::hypot(contact.sigma_m / contact.depth_m,
                                      is_foot ? 0.0 : kLeanPerM * static_cast<double>(height_m));
      anchors.push_back({cv::Point2f(static_cast<float>(column), static_cast<float>(row)),
                         1.0 / static_cast<double>(depth), sigma, kContactGate});
    }
  }
  return anchors;
}

std::string mainCue(const SeenObstacle& seen, const NearestObstacle& obstacle, const DepthView& view,
                    const std::vector<FloorContact>& contacts, bool uses_floor) {
  double floor = 0.0;  // information of each cue on the relative depth
  for (int column = seen.first_column; uses_floor && column <= seen.last_column; ++column) {
    const FloorContact& contact = contacts[static_cast<std::size_t>(column)];
    if (contact.state != FloorContact::State::kContact) continue;
    floor += std::pow(contact.depth_m / contact.sigma_m, 2);
  }
  double vo = 0.0;
  const cv::Rect region(obstacle.left_px, obstacle.top_px, obstacle.width_px, obstacle.height_px);
  for (const MetricPoint& point : view.points) {
    const double depth = depthOf(point.p_odom, view);
    if (!region.contains(point.pixel) || !(depth > kNearest_m) || !(point.sigma_m >= 0.0)) continue;
    vo += std::pow(depth / std::hypot(point.sigma_m, 0.02 * depth), 2);
  }
  if (floor <= 0.0 && vo <= 0.0) return "network";
  return vo > floor ? "vo" : "floor";
}

}  // namespace frugal_nav
