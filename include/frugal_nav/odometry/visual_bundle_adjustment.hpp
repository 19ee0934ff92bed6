#pragma once

#include <optional>

#include <frugal_nav/odometry/visual_map.hpp>

namespace frugal_nav {

/// What holds a window of views besides its points.
struct BundleSettings {
  double focal_px = 0.0;
  std::size_t window = 6;  ///< newest keyframes that move; at least the oldest one does not
  double wheel_sigma = 0.01;
  double wheel_sigma_m = 0.002;
  double min_wheel_distance_m = 0.02;
  std::optional<PlanarPrior> planar;
  int max_iterations = 6;
};

/// What an adjustment did.
struct BundleResult {
  bool is_usable = false;
  double rms_before_px = 0.0;
  double rms_after_px = 0.0;
  int residuals = 0;
};

/// Adjusts the map's keyframes and points together (Huber on pixels, Cauchy on wheel distances between
/// neighbouring keyframes). Keyframes older than the window stay. When only one stays and there is no wheel
/// distance, the second one stays too, so that the scale is kept.
BundleResult adjustBundle(VisualMap& map, const BundleSettings& settings);

}  // namespace frugal_nav
