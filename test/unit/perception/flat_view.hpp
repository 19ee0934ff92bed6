#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/perception/depth_gap.hpp>
#include <frugal_nav/perception/view_rays.hpp>

namespace frugal_nav::test {

/// The robot's camera: 640x480, 62 degrees wide, 0.4 m over the floor, pitched 5 degrees up, over base_link.
inline Pinhole flatCamera() {
  Pinhole camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx = camera.fy = 532.0;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return camera;
}

inline Eigen::Isometry3d flatMount() {
  Eigen::Isometry3d mount = Eigen::Isometry3d::Identity();
  mount.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  mount.prerotate(Eigen::AngleAxisd(-5.0 * M_PI / 180.0, Eigen::Vector3d::UnitY()));
  mount.translation().z() = 0.4;
  return mount;
}

/// An upright board across the robot's x axis, standing on the floor of base_link.
struct Board {
  double x_m = 2.0;
  double right_m = -0.2;  ///< y of its edges
  double left_m = 0.2;
  double height_m = 0.6;
  cv::Vec3b colour{60, 60, 200};
};

/// A room of boards in front of a wall, as each cell of a grid sees it, without noise or blur.
class FlatView {
 public:
  explicit FlatView(const cv::Size& grid = {160, 120}) : rays_(flatCamera(), flatMount(), grid) {}

  std::vector<Board> boards;
  double wall_x_m = 5.0;
  cv::Vec3b floor_colour{110, 140, 120};
  cv::Vec3b floor_colour_2{110, 140, 120};  ///< of every other tile
  double tile_m = 0.5;
  cv::Vec3b wall_colour{190, 190, 185};

  const ViewRays& rays() const { return rays_; }

  /// 1 / depth along the optical axis [1/m], CV_32FC1.
  cv::Mat inverseDepth() const {
    cv::Mat map(rays_.grid(), CV_32FC1);
    for (int row = 0; row < map.rows; ++row) {
      for (int column = 0; column < map.cols; ++column)
        map.at<float>(row, column) = static_cast<float>(see(rays_.ray(row, column).cast<double>()).first);
    }
    return map;
  }

  /// The image, CV_8UC3, of a size with the camera's shape.
  cv::Mat image(const cv::Size& size = {640, 480}) const {
    const ViewRays fine(flatCamera().scaled(size.width, size.height), flatMount(), size);
    cv::Mat bgr(size, CV_8UC3);
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column)
        bgr.at<cv::Vec3b>(row, column) = see(fine.ray(row, column).cast<double>()).second;
    }
    return bgr;
  }

  /// Whether each cell shows the floor: CV_8UC1, 255 or 0.
  cv::Mat floor() const {
    cv::Mat mask(rays_.grid(), CV_8UC1);
    const cv::Mat inverse = inverseDepth();
    for (int row = 0; row < mask.rows; ++row) {
      for (int column = 0; column < mask.cols; ++column) {
        const float floor_pm = rays_.inverseFloorDepth(row, column);
        mask.at<uchar>(row, column) =
            floor_pm > 0.0F && std::abs(inverse.at<float>(row, column) - floor_pm) < 1e-6F ? 255 : 0;
      }
    }
    return mask;
  }

 private:
  std::pair<double, cv::Vec3b> see(const Eigen::Vector3d& ray) const {
    std::pair<double, cv::Vec3b> seen{ray.x() / wall_x_m, wall_colour};
    const double floor = -ray.z() / 0.4;
    if (floor > seen.first) {
      const Eigen::Vector2d p = ray.head<2>() / floor;
      const auto tile = static_cast<int>(std::floor(p.x() / tile_m) + std::floor(p.y() / tile_m));
      seen = {floor, tile % 2 == 0 ? floor_colour : floor_colour_2};
    }
    for (const Board& board : boards) {
      const double inverse = ray.x() / board.x_m;
      const Eigen::Vector3d p = Eigen::Vector3d(0.0, 0.0, 0.4) + ray / inverse;
      const bool hits = p.y() > board.right_m && p.y() < board.left_m && p.z() < board.height_m;
      if (hits && inverse > seen.first) seen = {inverse, board.colour};
    }
    return seen;
  }

  ViewRays rays_;
};

/// A network that gives what it is told to: z of 1 / depth = a z + b, and perhaps the floor.
class ToldNetwork : public DepthNetwork {
 public:
  struct Told {
    cv::Mat inverse_depth_pm;
    double a = 2.0;
    double b = 0.05;
    cv::Mat floor;  ///< probability; empty for a network that does not tell
  };
  explicit ToldNetwork(std::shared_ptr<Told> told) : told_(std::move(told)) {}
  DepthPrediction infer(const cv::Mat&) override {
    return {(told_->inverse_depth_pm - told_->b) / told_->a, told_->floor};
  }
  bool isMetric() const override { return false; }

 private:
  std::shared_ptr<Told> told_;
};

}  // namespace frugal_nav::test
