#pragma once

// Pictures of printed markers as a camera would take them, exact to a fraction of a pixel.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/perception/marker_detector.hpp>
#include <frugal_nav/perception/marker_dictionary.hpp>
#include <frugal_nav/perception/marker_map.hpp>

namespace frugal_nav::test {

/// 640x480, 62 degrees wide.
inline Pinhole straightCamera() {
  Pinhole camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx = camera.fy = 530.0;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return camera;
}

/// The same through a lens with barrel distortion.
inline Pinhole bentCamera() {
  Pinhole camera = straightCamera();
  camera.fy = 525.0;
  camera.k1 = -0.25;
  camera.k2 = 0.07;
  camera.p1 = 0.0008;
  camera.p2 = -0.0006;
  return camera;
}

/// How a picture comes about.
struct MarkerLight {
  double white = 200.0;
  double black = 30.0;
  double wall = 120.0;
  double blur_px = 0.7;
  double noise = 0.0;  ///< standard deviation of grey values
  double border_share = 0.2;
};

/// Draws a marker over what is there: each pixel is the mean over the square it covers.
inline void drawMarker(const MarkerDictionary& dictionary, int id, double size_m, const Pinhole& camera,
                       const Eigen::Isometry3d& camera_from_marker, const MarkerLight& light,
                       cv::Mat& image) {
  constexpr int kSamples = 5;
  const cv::Mat cells = dictionary.cellsOf(id);
  const double sheet_half_m = size_m * (0.5 + light.border_share);
  const Eigen::Isometry3d marker_from_camera = camera_from_marker.inverse();
  const Eigen::Vector3d eye = marker_from_camera.translation();
  if (eye.z() <= 0.0) return;  // its back
  Eigen::Vector2d low(1e9, 1e9);
  Eigen::Vector2d high(-1e9, -1e9);
  for (const Eigen::Vector3d& corner : markerCorners(2.0 * sheet_half_m)) {
    const auto pixel = camera.project(camera_from_marker * corner);
    if (!pixel) return;
    low = low.cwiseMin(*pixel);
    high = high.cwiseMax(*pixel);
  }
  constexpr int kMargin_px = 6;  // a bent edge bulges over its corners
  const cv::Rect box =
      cv::Rect(cv::Point(static_cast<int>(low.x()) - kMargin_px, static_cast<int>(low.y()) - kMargin_px),
               cv::Point(static_cast<int>(high.x()) + kMargin_px, static_cast<int>(high.y()) + kMargin_px)) &
      cv::Rect(0, 0, image.cols, image.rows);
  for (int y = box.y; y < box.y + box.height; ++y) {
    for (int x = box.x; x < box.x + box.width; ++x) {
      double sum = 0.0;
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const Eigen::Vector2d pixel(x - 0.5 + (s % kSamples + 0.5) / kSamples,
                                    y - 0.5 + (s / kSamples + 0.5) / kSamples);
        double grey = image.at<float>(y, x);
        if (const auto look = camera.lookThrough(pixel)) {
          const Eigen::Vector3d ray = marker_from_camera.linear() * look->point.homogeneous();
          const double along = -eye.z() / ray.z();
          const Eigen::Vector3d p = eye + along * ray;
          if (along > 0.0 && std::max(std::abs(p.x()), std::abs(p.y())) < sheet_half_m) {
            const int column = static_cast<int>(std::floor((p.x() / size_m + 0.5) * cells.cols));
            const int row = static_cast<int>(std::floor((0.5 - p.y() / size_m) * cells.rows));
            const bool in_code = row >= 0 && row < cells.rows && column >= 0 && column < cells.cols;
            grey = in_code && cells.at<unsigned char>(row, column) == 0 ? light.black : light.white;
          }
        }
        sum += grey;
      }
      image.at<float>(y, x) = static_cast<float>(sum / (kSamples * kSamples));
    }
  }
}

/// The byte of an image in sRGB for light from 0 to 255.
inline double encoded(double light) {
  const double share = std::clamp(light / 255.0, 0.0, 1.0);
  return 255.0 * (share <= 0.0031308 ? 12.92 * share : 1.055 * std::pow(share, 1.0 / 2.4) - 0.055);
}

/// What a lens and a sensor make of a drawing, whose values are light.
inline cv::Mat expose(cv::Mat drawing, const MarkerLight& light, Random& random) {
  if (light.blur_px > 0.0) cv::GaussianBlur(drawing, drawing, {0, 0}, light.blur_px);
  cv::Mat image(drawing.size(), CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double grey =
          encoded(drawing.at<float>(y, x)) + (light.noise > 0.0 ? random.normal(light.noise) : 0.0);
      image.at<unsigned char>(y, x) = cv::saturate_cast<unsigned char>(grey);
    }
  }
  return image;
}

/// One marker before a wall.
inline cv::Mat viewOf(const MarkerDictionary& dictionary, int id, double size_m, const Pinhole& camera,
                      const Eigen::Isometry3d& camera_from_marker, const MarkerLight& light, Random& random) {
  cv::Mat drawing(camera.height_px, camera.width_px, CV_32FC1, cv::Scalar(light.wall));
  drawMarker(dictionary, id, size_m, camera, camera_from_marker, light, drawing);
  return expose(drawing, light, random);
}

/// All markers of a map, the farthest first.
inline cv::Mat viewOf(const MarkerMap& map, const Pinhole& camera, const Eigen::Isometry3d& map_from_camera,
                      const MarkerLight& light, Random& random) {
  cv::Mat drawing(camera.height_px, camera.width_px, CV_32FC1, cv::Scalar(light.wall));
  std::vector<std::pair<Eigen::Isometry3d, const MappedMarker*>> ordered;
  for (const auto& entry : map.markers)
    ordered.emplace_back(map_from_camera.inverse() * entry.second.map_from_marker, &entry.second);
  std::sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) {
    return a.first.translation().norm() > b.first.translation().norm();
  });
  const MarkerDictionary dictionary(map.dictionary);
  for (const auto& [camera_from_marker, marker] : ordered)
    drawMarker(dictionary, marker->id, marker->size_m, camera, camera_from_marker, light, drawing);
  return expose(drawing, light, random);
}

/// A marker before the camera: `yaw_rad` turns its face to the side, `pitch_rad` up, `roll_rad` in its plane.
inline Eigen::Isometry3d facingCamera(const Eigen::Vector3d& centre_m, double yaw_rad, double pitch_rad = 0.0,
                                      double roll_rad = 0.0) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = centre_m;
  pose.linear() = (Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

/// Four markers on a wall.
inline MarkerMap wallMap() {
  return loadMarkerMap(std::string(FRUGAL_NAV_SOURCE_DIR) + "/test/data/marker_wall.yaml");
}

/// A camera 0.3 m over the floor that looks ahead and 5 degrees up.
inline Eigen::Isometry3d mounted() {
  Eigen::Matrix3d base_from_level;
  base_from_level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(-5.0 * M_PI / 180.0, Eigen::Vector3d::UnitY()) * base_from_level;
  pose.translation() = Eigen::Vector3d(0.12, 0.02, 0.3);
  return pose;
}

/// That camera in the map.
inline Eigen::Isometry3d cameraAt(const Pose2& map_from_base) {
  return toIsometry(map_from_base) * mounted();
}

/// Where the camera sees the corners of all markers of a map, with noise.
inline std::vector<MarkerCorners> seen(const MarkerMap& map, const Pinhole& camera,
                                       const Pose2& map_from_base, double sigma_px, Random& random) {
  std::vector<MarkerCorners> markers;
  const Eigen::Isometry3d camera_from_map = cameraAt(map_from_base).inverse();
  for (const auto& [id, marker] : map.markers) {
    MarkerCorners corners;
    corners.id = id;
    for (std::size_t i = 0; i < 4; ++i) {
      corners.pixels[i] = *camera.project(camera_from_map * marker.map_from_marker * marker.corners()[i]);
      if (sigma_px > 0.0)
        corners.pixels[i] += Eigen::Vector2d(random.normal(sigma_px), random.normal(sigma_px));
    }
    markers.push_back(corners);
  }
  return markers;
}

}  // namespace frugal_nav::test
