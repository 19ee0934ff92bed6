#pragma once

#include <limits>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/types.hpp>

#include <frugal_nav/common/pinhole.hpp>

namespace frugal_nav {

/// Where each cell of a grid laid over the image looks, in base_link: computed once for a camera that stays
/// where it is. A cell's place is that of its middle. Depths are along the optical axis [m].
class ViewRays {
 public:
  /// `camera` is that of the image the grid is laid over.
  ViewRays(const Pinhole& camera, const Eigen::Isometry3d& base_from_optical, const cv::Size& grid);

  /// Whether it was made for these.
  bool fits(const Pinhole& camera, const Eigen::Isometry3d& base_from_optical, const cv::Size& grid) const;

  const cv::Size& grid() const { return grid_; }
  const Pinhole& camera() const { return camera_; }
  const Eigen::Isometry3d& baseFromOptical() const { return base_from_optical_; }
  double cameraHeight_m() const { return base_from_optical_.translation().z(); }

  /// The way from the camera to the point at depth one, in base_link; NaN where the lens has no inverse.
  const Eigen::Vector3f& ray(int row, int column) const {
    return rays_[static_cast<std::size_t>(row * grid_.width + column)];
  }
  /// The same for any place in the image as given [px].
  Eigen::Vector3d rayThrough(const Eigen::Vector2d& pixel) const;

  /// The point at a depth, in base_link.
  Eigen::Vector3f point(int row, int column, float depth_m) const {
    return origin_ + depth_m * ray(row, column);
  }
  /// Height over the floor at a depth [m].
  float heightAt(int row, int column, float depth_m) const {
    return origin_.z() + depth_m * ray(row, column).z();
  }
  /// Depth at a row of what stands upright where the column's `foot_row` shows it at `depth_m`: a camera that
  /// looks up or down sees head and foot at different depths.
  float uprightDepth(int row, int foot_row, int column, float depth_m) const {
    return depth_m * ray(foot_row, column).head<2>().norm() / ray(row, column).head<2>().norm();
  }
  /// 1 / depth at which a ray meets the floor [1/m]; 0 at the horizon, negative above it.
  float inverseFloorDepth(int row, int column) const { return -ray(row, column).z() / origin_.z(); }

  /// First row of a column that looks below the horizon by at least `margin_rad`.
  int firstRowBelowHorizon(int column, double margin_rad = 0.0) const;

  /// Places of the image as given, in cells, and back: the grid's whole numbers are the cells' middles.
  Eigen::Vector2d toGrid(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d toImage(const Eigen::Vector2d& cell) const;

 private:
  Pinhole camera_;
  Eigen::Isometry3d base_from_optical_;
  cv::Size grid_;
  Eigen::Vector3f origin_;
  std::vector<Eigen::Vector3f> rays_;
};

}  // namespace frugal_nav
