#include <cmath>
#include <map>

#include <frugal_nav/odometry/visual_obstacle.hpp>
#include <frugal_nav/perception/dbscan.hpp>

namespace frugal_nav {
namespace {

bool contains(const cv::Rect& region, const Eigen::Vector2d& pixel) {
  return pixel.x() >= region.x && pixel.x() < region.x + region.width && pixel.y() >= region.y &&
         pixel.y() < region.y + region.height;
}

/// The points of the region that may be part of an obstacle.
std::vector<const VisualPoint*> candidates(const VisualOdometryOutput& output, const cv::Rect& region,
                                           const VisualObstacleParams& params) {
  std::vector<const VisualPoint*> chosen;
  for (const VisualPoint& point : output.points) {
    const double height_m = (output.odom_from_base.inverse() * point.p_odom).z();
    if (contains(region, point.pixel) && height_m >= params.min_height_m && height_m <= params.max_height_m &&
        point.sigma_m <= params.max_relative_sigma * point.p_camera.norm())
      chosen.push_back(&point);
  }
  return chosen;
}

VisualObstacle summarize(const std::vector<const VisualPoint*>& cluster, const VisualOdometryOutput& output) {
  VisualObstacle out;
  double weight_sum = 0.0;
  for (const VisualPoint* point : cluster) {
    out.p_odom += point->p_odom / static_cast<double>(cluster.size());
    weight_sum += 1.0 / (point->sigma_m * point->sigma_m);
  }
  const Eigen::Vector3d p_base = output.odom_from_base.inverse() * out.p_odom;
  out.distance_m = p_base.head<2>().norm();
  out.bearing_rad = std::atan2(p_base.y(), p_base.x());
  double spread = 0.0;
  for (const VisualPoint* point : cluster) {
    const double distance_m = (output.odom_from_base.inverse() * point->p_odom).head<2>().norm();
    spread += (distance_m - out.distance_m) * (distance_m - out.distance_m);
  }
  const double count = static_cast<double>(cluster.size());
  const double scale_sigma = std::isfinite(output.status.scale_sigma) ? output.status.scale_sigma : 0.0;
  out.points = static_cast<int>(cluster.size());
  out.sigma_m = std::sqrt(1.0 / weight_sum + spread / (count * count) +
                          scale_sigma * scale_sigma * out.distance_m * out.distance_m);
  return out;
}

}  // namespace

VisualObstacleResult findNearestObstacle(const VisualOdometryOutput& output, const cv::Rect& region,
                                         const VisualObstacleParams& params) {
  VisualObstacleResult result;
  for (const cv::Point2f& pixel : output.features)
    result.keypoints += contains(region, {pixel.x, pixel.y}) ? 1 : 0;
  if (!output.is_metric) {
    result.reason = "the scale is unknown";
    return result;
  }
  if (result.keypoints < params.min_keypoints) {
    result.reason = "only " + std::to_string(result.keypoints) + " keypoints in the region, " +
                    std::to_string(params.min_keypoints) + " are needed";
    return result;
  }
  const std::vector<const VisualPoint*> chosen = candidates(output, region, params);
  std::vector<Eigen::Vector3d> positions;
  for (const VisualPoint* point : chosen) positions.push_back(point->p_odom);
  const std::vector<int> labels = dbscan(positions, params.eps_m, params.min_samples);
  std::map<int, std::vector<const VisualPoint*>> clusters;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] != kNoise) clusters[labels[i]].push_back(chosen[i]);
  }
  for (const auto& [label, cluster] : clusters) {
    const VisualObstacle obstacle = summarize(cluster, output);
    if (!result.obstacle || obstacle.distance_m < result.obstacle->distance_m) result.obstacle = obstacle;
  }
  if (!result.obstacle)
    result.reason = "no cluster among " + std::to_string(chosen.size()) + " points of the region";
  return result;
}

}  // namespace frugal_nav
