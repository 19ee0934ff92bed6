#include <algorithm>
#include <cmath>

#include <frugal_nav/odometry/visual_map.hpp>

namespace frugal_nav {
namespace {

constexpr double kPixelSigma_px = 0.5;       // of a followed feature: what optical flow reaches over a window
constexpr int kWellSeen = 3;                 // keyframes
constexpr double kRetiredShare = 0.08;       // sigma over depth of a point that is worth keeping
constexpr std::size_t kRetiredLimit = 5000;  // when nobody takes them

}  // namespace

void VisualMap::addKeyframe(Keyframe keyframe) {
  keyframes_.push_back(std::move(keyframe));
  while (keyframes_.size() > static_cast<std::size_t>(params_.window + params_.fixed_keyframes))
    keyframes_.pop_front();
}

std::vector<Sight> VisualMap::sightsOf(std::int64_t id) const {
  std::vector<Sight> sights;
  for (const Keyframe& keyframe : keyframes_) {
    const auto ray = keyframe.rays.find(id);
    if (ray != keyframe.rays.end()) sights.push_back({keyframe.odom_from_camera, ray->second});
  }
  return sights;
}

int VisualMap::triangulateNew() {
  if (keyframes_.size() < 2) return 0;
  int made = 0;
  for (const auto& [id, ray] : keyframes_.back().rays) {
    if (landmarks_.count(id) != 0) continue;
    const std::vector<Sight> sights = sightsOf(id);
    const std::optional<Triangulation> point = triangulate(sights, focal_px_);
    if (!point || point->parallax_rad < params_.min_parallax_rad) continue;
    const double depth_m = (keyframes_.back().odom_from_camera.inverse() * point->p_world).z();
    if (point->error_px > params_.max_reprojection_px || depth_m > params_.max_depth_m) continue;
    Landmark landmark;
    landmark.p_odom = point->p_world;
    landmarks_[id] = landmark;
    ++made;
  }
  return made;
}

void VisualMap::clean() {
  for (auto it = landmarks_.begin(); it != landmarks_.end();) {
    Landmark& landmark = it->second;
    std::vector<Eigen::Vector3d> directions;
    double least_cos = 1.0;
    double depth_m = 0.0;
    for (Keyframe& keyframe : keyframes_) {
      const auto ray = keyframe.rays.find(it->first);
      if (ray == keyframe.rays.end()) continue;
      const Eigen::Vector3d p = keyframe.odom_from_camera.inverse() * landmark.p_odom;
      const bool fits = p.z() > 0.0 &&
                        focal_px_ * (p.head<2>() / p.z() - ray->second).norm() <= params_.max_reprojection_px;
      if (!fits) {
        keyframe.rays.erase(ray);
        continue;
      }
      depth_m = p.z();
      const Eigen::Vector3d d = (landmark.p_odom - keyframe.odom_from_camera.translation()).normalized();
      for (const Eigen::Vector3d& other : directions) least_cos = std::min(least_cos, d.dot(other));
      directions.push_back(d);
    }
    landmark.sights = static_cast<int>(directions.size());
    if (landmark.sights >= 2) {
      landmark.most_sights = std::max(landmark.most_sights, landmark.sights);
      landmark.parallax_rad = std::max(1e-4, std::acos(std::clamp(least_cos, -1.0, 1.0)));
      landmark.sigma_m = depth_m * kPixelSigma_px / focal_px_ / landmark.parallax_rad;
      ++it;
    } else {
      if (landmark.sights == 0 || landmark.most_sights >= kWellSeen) retire(landmark);
      it = landmarks_.erase(it);
    }
  }
}

void VisualMap::retire(const Landmark& landmark) {
  if (landmark.most_sights < kWellSeen || retired_.size() >= kRetiredLimit || keyframes_.empty()) return;
  const double distance_m = (landmark.p_odom - keyframes_.back().odom_from_camera.translation()).norm();
  if (landmark.sigma_m <= kRetiredShare * distance_m) retired_.push_back(landmark.p_odom);
}

std::vector<Eigen::Vector3d> VisualMap::takeRetired() {
  std::vector<Eigen::Vector3d> taken;
  taken.swap(retired_);
  return taken;
}

std::optional<double> VisualMap::medianDepth() const {
  if (keyframes_.empty()) return std::nullopt;
  std::vector<double> depths;
  const Eigen::Isometry3d camera_from_odom = keyframes_.back().odom_from_camera.inverse();
  for (const auto& [id, ray] : keyframes_.back().rays) {
    const auto landmark = landmarks_.find(id);
    if (landmark != landmarks_.end()) depths.push_back((camera_from_odom * landmark->second.p_odom).z());
  }
  if (depths.empty()) return std::nullopt;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

void VisualMap::rescale(double factor, const Eigen::Vector3d& about_odom) {
  for (Keyframe& keyframe : keyframes_) {
    Eigen::Vector3d position = keyframe.odom_from_camera.translation();
    position = about_odom + factor * (position - about_odom);
    keyframe.odom_from_camera.translation() = position;
  }
  for (auto& [id, landmark] : landmarks_) {
    landmark.p_odom = about_odom + factor * (landmark.p_odom - about_odom);
    landmark.sigma_m *= factor;
  }
}

void VisualMap::clear() {
  for (const auto& [id, landmark] : landmarks_) retire(landmark);
  landmarks_.clear();
  keyframes_.clear();
}

}  // namespace frugal_nav
