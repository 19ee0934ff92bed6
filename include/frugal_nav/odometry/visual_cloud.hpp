#pragma once

#include <vector>

#include <Eigen/Core>

namespace frugal_nav {

/// The accumulated map of visual odometry: one mean point a voxel.
class VisualCloud {
 public:
  /// Voxels are cubes of this side [m]; at most `max_points` are kept.
  explicit VisualCloud(double voxel_m = 0.05, std::size_t max_points = 200000)
      : voxel_m_(voxel_m), max_points_(max_points) {}

  /// Adds points of the odom frame; those not finite are left out.
  void add(const std::vector<Eigen::Vector3d>& points_odom);
  void clear();
  /// The points, voxel-filtered (PCL).
  const std::vector<Eigen::Vector3f>& points() const;

 private:
  void filter() const;

  double voxel_m_;
  std::size_t max_points_;
  mutable std::vector<Eigen::Vector3f> points_;
  mutable bool is_filtered_ = true;
};

}  // namespace frugal_nav
