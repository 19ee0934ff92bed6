#include "detector_support.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include <frugal_nav/perception/contact_memory.hpp>

namespace frugal_nav {
namespace {

/// A place seen by the camera: its cell in the grid, which may lie outside, and its depth.
struct Seen {
  Eigen::Vector2d cell;
  double depth_m;
};

std::optional<Seen> see(const Eigen::Vector2d& p_base, double height_m, const ViewRays& rays) {
  const Eigen::Vector3d p_optical =
      rays.baseFromOptical().inverse() * Eigen::Vector3d(p_base.x(), p_base.y(), height_m);
  constexpr double kNearest_m = 0.1;
  if (p_optical.z() < kNearest_m) return std::nullopt;
  const auto pixel = rays.camera().project(p_optical);
  if (!pixel) return std::nullopt;
  return Seen{rays.toGrid(*pixel), p_optical.z()};
}

bool isWithin(const Eigen::Vector2d& cell, const cv::Size& grid) {
  return cell.x() > -0.5 && cell.y() > -0.5 && cell.x() < grid.width - 0.5 && cell.y() < grid.height - 0.5;
}

}  // namespace

ContactMemory::ContactMemory(const ContactMemoryParams& params)
    : params_(validated(params, "contact memory")) {}

std::vector<DepthAnchor> ContactMemory::recall(Stamp stamp, const Pose2& odom_from_base,
                                               const ViewRays& rays) const {
  constexpr double kHeightStep_m = 0.03;
  constexpr double kHighest_m = 0.6;
  constexpr double kGate = 1.0;  // the network may be far off in what fills the view
  const Pose2 base_from_odom = odom_from_base.inverse();
  std::vector<DepthAnchor> anchors;
  std::vector<double> nearest(static_cast<std::size_t>(rays.grid().width), params_.max_depth_m);
  for (const auto& [cell, foot] : feet_) {
    const double age_s = toSeconds(stamp - foot.seen);
    if (age_s > params_.max_age_s) continue;
    const Eigen::Vector2d p_base = base_from_odom * foot.p_odom;
    const std::optional<Seen> low = see(p_base, 0.0, rays);
    if (low && isWithin(low->cell, rays.grid())) continue;  // the image itself tells
    double highest_m = kHighest_m;  // what is seen of it begins the higher the nearer it is
    for (double height = kHeightStep_m; height <= highest_m; height += kHeightStep_m) {
      const std::optional<Seen> seen = see(p_base, height, rays);
      if (!seen || !isWithin(seen->cell, rays.grid())) continue;
      highest_m = std::min(highest_m, height + params_.height_m);
      double& limit = nearest[static_cast<std::size_t>(std::lround(seen->cell.x()))];
      constexpr double kSameThing = 1.15;
      if (seen->depth_m > kSameThing * limit) continue;  // hidden behind another
      limit = std::min(limit, seen->depth_m);
      anchors.push_back({cv::Point2f(static_cast<float>(seen->cell.x()), static_cast<float>(seen->cell.y())),
                         1.0 / seen->depth_m,
                         std::hypot(foot.sigma_m / seen->depth_m, 0.01 + params_.drift_per_s * age_s),
                         kGate});
    }
  }
  return anchors;
}

void ContactMemory::update(Stamp stamp, const Pose2& odom_from_base, const ViewRays& rays,
                           const std::vector<FloorContact>& contacts) {
  const Pose2 base_from_odom = odom_from_base.inverse();
  for (auto it = feet_.begin(); it != feet_.end();) {
    const std::optional<Seen> seen = see(base_from_odom * it->second.p_odom, 0.0, rays);
    const bool is_renewed = seen && isWithin(seen->cell, rays.grid());
    const bool is_old = toSeconds(stamp - it->second.seen) > params_.max_age_s;
    it = is_renewed || is_old ? feet_.erase(it) : std::next(it);
  }
  for (int column = 0; column < rays.grid().width; ++column) {
    const FloorContact& contact = contacts[static_cast<std::size_t>(column)];
    if (contact.state != FloorContact::State::kContact || contact.depth_m > params_.max_depth_m) continue;
    const Eigen::Vector3d ray = rays.rayThrough({rays.toImage({column, 0}).x(), contact.image_row});
    const Eigen::Vector3d p_base = rays.baseFromOptical().translation() + contact.depth_m * ray;
    const Eigen::Vector2d p_odom = odom_from_base * Eigen::Vector2d(p_base.head<2>());
    const auto index = [this](double x) { return static_cast<int>(std::floor(x / params_.cell_m)); };
    feet_[{index(p_odom.x()), index(p_odom.y())}] = {p_odom, contact.sigma_m, stamp};
  }
}

}  // namespace frugal_nav
