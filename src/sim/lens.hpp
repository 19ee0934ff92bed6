#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/matx.hpp>

#include <frugal_nav/sim/camera.hpp>

namespace frugal_nav::sim {

/// Where each pixel looks: OpenCV's pinhole camera with plumb-bob distortion, inverted exactly.
class Lens {
 public:
  /// Throws ConfigError when the distortion folds the image over, so that a pixel has no direction of its
  /// own.
  explicit Lens(const CameraParams& params);

  int width() const { return width_; }
  int height() const { return height_; }
  float focal_px() const { return static_cast<float>(focal_px_); }
  cv::Matx33d matrix() const;

  /// The direction of a pixel is (rayX, rayY, 1) in the optical frame: a ray's length in these units is
  /// depth.
  float rayX(int column, int row) const { return x_[index(column, row)]; }
  float rayY(int column, int row) const { return y_[index(column, row)]; }

 private:
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(column);
  }

  int width_;
  int height_;
  double focal_px_;
  std::vector<float> x_;
  std::vector<float> y_;
};

}  // namespace frugal_nav::sim
