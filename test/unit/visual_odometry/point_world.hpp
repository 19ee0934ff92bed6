#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/odometry/visual_estimator.hpp>
#include <frugal_nav/odometry/visual_odometry.hpp>

namespace frugal_nav {

/// frugal_bot's camera: behind the axle, 0.4 m high, looking ahead and 5 degrees up.
inline Eigen::Isometry3d cameraMount() {
  Eigen::Isometry3d mount = Eigen::Isometry3d::Identity();
  mount.translation() << -0.12, 0.0, 0.40;
  Eigen::Matrix3d optical;
  optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  mount.linear() = Eigen::AngleAxisd(-0.0873, Eigen::Vector3d::UnitY()).toRotationMatrix() * optical;
  return mount;
}

/// A 640x480 camera, 62 degrees wide.
inline Pinhole testCamera() { return {640, 480, 530.0, 530.0, 319.5, 239.5, 0.0, 0.0, 0.0, 0.0, 0.0}; }

/// Points on the walls, the floor and on boxes of a room 8 m wide, and what a camera sees of them.
class PointWorld {
 public:
  explicit PointWorld(std::uint64_t seed, int points = 4000) : random_(seed) {
    for (int i = 0; i < points; ++i) {
      const double along = random_.uniform(-4.0, 4.0);
      const double up = random_.uniform(0.0, 2.5);
      switch (i % 6) {
        case 0:
          points_.emplace_back(4.0, along, up);
          break;
        case 1:
          points_.emplace_back(-4.0, along, up);
          break;
        case 2:
          points_.emplace_back(along, 4.0, up);
          break;
        case 3:
          points_.emplace_back(along, -4.0, up);
          break;
        case 4:
          points_.emplace_back(along, random_.uniform(-4.0, 4.0), 0.0);
          break;
        default:
          points_.emplace_back(random_.uniform(2.0, 3.0), random_.uniform(-2.0, 2.0), 0.4 * up);
      }
    }
  }

  /// Rays to what is in view, with noise on the pixels.
  RayMap see(const Eigen::Isometry3d& world_from_camera, double noise_px,
             const Pinhole& camera = testCamera()) {
    RayMap rays;
    const Eigen::Isometry3d camera_from_world = world_from_camera.inverse();
    for (std::size_t i = 0; i < points_.size() && rays.size() < 400; ++i) {
      const Eigen::Vector3d p = camera_from_world * points_[i];
      const auto pixel = camera.project(p);
      if (!pixel || p.z() < 0.2 || pixel->x() < 0.0 || pixel->y() < 0.0 ||
          pixel->x() > camera.width_px - 1.0 || pixel->y() > camera.height_px - 1.0)
        continue;
      const Ray2 noise(random_.normal(noise_px / camera.fx), random_.normal(noise_px / camera.fy));
      rays[static_cast<std::int64_t>(i)] = p.head<2>() / p.z() + noise;
    }
    return rays;
  }

  const std::vector<Eigen::Vector3d>& points() const { return points_; }

 private:
  Random random_;
  std::vector<Eigen::Vector3d> points_;
};

}  // namespace frugal_nav
