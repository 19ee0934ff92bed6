#pragma once

#include "worker_pool.hpp"

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <frugal_nav/sim/camera.hpp>

namespace frugal_nav::sim {

/// How long and how strongly a sensor integrates.
struct Exposure {
  double time_s = 0.0;
  double gain = 1.0;
};

/// Turns light into an 8-bit image as a CMOS sensor does: electrons, shot and read noise, gain, saturation,
/// quantisation, sRGB curve; and chooses the next exposure.
class ImageSensor {
 public:
  ImageSensor(const CameraParams& params, std::uint64_t seed);

  /// The image of a frame of light [lx], CV_8UC3 BGR. Moves the exposure toward the target.
  cv::Mat read(const std::vector<Eigen::Vector3f>& light_lx, WorkerPool& pool);

  const Exposure& exposure() const { return exposure_; }

 private:
  double readRow(const Eigen::Vector3f* light_lx, int row, std::uint8_t* bgr) const;
  void adaptExposure(double mean_signal);

  CameraParams params_;
  std::uint64_t seed_;
  std::uint64_t frame_ = 0;
  Exposure exposure_;
  std::vector<std::uint8_t> curve_;  // sRGB byte of a linear signal in [0, 1]
  std::vector<double> row_means_;
};

}  // namespace frugal_nav::sim
