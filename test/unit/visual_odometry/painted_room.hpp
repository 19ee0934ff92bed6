#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include <frugal_nav/common/pinhole.hpp>

namespace frugal_nav {

/// A room of 6 m x 6 m x 3 m with noise painted on its walls and floor, ray by ray: no more than a camera
/// that needs no simulator.
class PaintedRoom {
 public:
  explicit PaintedRoom(std::uint32_t seed) : seed_(seed) {}

  /// The grey image of a camera in the room, 8 bits.
  cv::Mat look(const Eigen::Isometry3d& room_from_camera, const Pinhole& camera) const {
    cv::Mat image(camera.height_px, camera.width_px, CV_8UC1);
    const Eigen::Vector3d origin = room_from_camera.translation();
    for (int row = 0; row < image.rows; ++row) {
      for (int column = 0; column < image.cols; ++column) {
        const Eigen::Vector3d ray((column - camera.cx) / camera.fx, (row - camera.cy) / camera.fy, 1.0);
        image.at<unsigned char>(row, column) = paint(origin, room_from_camera.linear() * ray);
      }
    }
    return image;
  }

 private:
  unsigned char paint(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) const {
    double nearest = 1e9;
    int wall = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double low = axis == 2 ? 0.0 : -3.0;
      const double bound = ray[axis] > 0.0 ? 3.0 : low;
      if (ray[axis] == 0.0) continue;
      const double along = (bound - origin[axis]) / ray[axis];
      if (along < nearest) {
        nearest = along;
        wall = 2 * axis + (ray[axis] > 0.0 ? 1 : 0);
      }
    }
    const Eigen::Vector3d p = origin + nearest * ray;
    const double u = wall < 2 ? p.y() : p.x();
    const double v = wall < 4 ? p.z() : p.y();
    const double grey =
        128.0 + 90.0 * noise(u / 0.3, v / 0.3, wall) + 60.0 * noise(u / 0.07, v / 0.07, wall + 8);
    return static_cast<unsigned char>(std::clamp(grey, 0.0, 255.0));
  }

  /// Smooth noise in [-1, 1]: random values on a lattice, blended between.
  double noise(double u, double v, int layer) const {
    const double u0 = std::floor(u);
    const double v0 = std::floor(v);
    const double a = blend(u - u0);
    const double b = blend(v - v0);
    const auto at = [&](int du, int dv) {
      return value(static_cast<std::uint32_t>(static_cast<int>(u0) + du + 4096),
                   static_cast<std::uint32_t>(static_cast<int>(v0) + dv + 4096),
                   static_cast<std::uint32_t>(layer));
    };
    return (1 - b) * ((1 - a) * at(0, 0) + a * at(1, 0)) + b * ((1 - a) * at(0, 1) + a * at(1, 1));
  }
  static double blend(double t) { return t * t * (3.0 - 2.0 * t); }
  double value(std::uint32_t x, std::uint32_t y, std::uint32_t layer) const {
    std::uint32_t h = seed_ + x * 374761393U + y * 668265263U + layer * 2246822519U;
    h = (h ^ (h >> 13U)) * 1274126177U;
    h ^= h >> 16U;
    return static_cast<double>(h & 0xffffU) / 32767.5 - 1.0;
  }

  std::uint32_t seed_;
};

}  // namespace frugal_nav
