#include "image_sensor.hpp"

#include "fast_noise.hpp"
#include "surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace frugal_nav::sim {
namespace {

constexpr int kCurveSize = 4096;
constexpr double kFirstGuess_lx = 200.0;  // light from a grey room: where the exposure starts
constexpr double kDamping = 0.7;          // of the exposure's step, in stops: settles in about four images
constexpr double kLargestStep = 8.0;      // of the exposure in one image: a black or white image says no more

}  // namespace

ImageSensor::ImageSensor(const CameraParams& params, std::uint64_t seed)
    : params_(params), seed_(seed), row_means_(static_cast<std::size_t>(params.height_px)) {
  for (int i = 0; i < kCurveSize; ++i) {
    const float srgb = srgbFromLinear((static_cast<float>(i) + 0.5F) / kCurveSize);
    curve_.push_back(static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(srgb, 0.0F, 1.0F))));
  }
  const double electrons_per_s = kFirstGuess_lx * params.electrons_per_lx_s;
  exposure_.time_s = std::clamp(params.exposure_target * params.full_well_e / electrons_per_s,
                                params.shortest_exposure_s, params.longest_exposure_s);
}

cv::Mat ImageSensor::read(const std::vector<Eigen::Vector3f>& light_lx, WorkerPool& pool) {
  constexpr int kRowsATask = 16;
  cv::Mat image(params_.height_px, params_.width_px, CV_8UC3);
  pool.run((params_.height_px + kRowsATask - 1) / kRowsATask, [&](int task) {
    const int last = std::min(params_.height_px, (task + 1) * kRowsATask);
    for (int row = task * kRowsATask; row < last; ++row) {
      const auto first = static_cast<std::size_t>(row) * static_cast<std::size_t>(params_.width_px);
      row_means_[static_cast<std::size_t>(row)] = readRow(&light_lx[first], row, image.ptr(row));
    }
  });
  ++frame_;
  adaptExposure(std::accumulate(row_means_.begin(), row_means_.end(), 0.0) / params_.height_px);
  return image;
}

/// One row of the image; returns its mean signal as a share of full scale.
double ImageSensor::readRow(const Eigen::Vector3f* light_lx, int row, std::uint8_t* bgr) const {
  FastNoise noise(seed_, frame_, static_cast<std::uint64_t>(row));
  const auto electrons_per_lx = static_cast<float>(params_.electrons_per_lx_s * exposure_.time_s);
  const auto read_variance = static_cast<float>(params_.read_noise_e * params_.read_noise_e);
  const float shot = params_.shot_noise ? 1.0F : 0.0F;
  const auto full_scale = static_cast<float>(params_.full_well_e / exposure_.gain);
  const float to_curve = kCurveSize / full_scale;
  float sum = 0.0F;
  for (int column = 0; column < params_.width_px; ++column) {
    for (int channel = 0; channel < 3; ++channel) {
      const float electrons = electrons_per_lx * light_lx[column][channel];
      const float collected = electrons + std::sqrt(shot * electrons + read_variance) * noise.gauss();
      const float level = std::clamp(collected * to_curve, 0.0F, kCurveSize - 1.0F);
      bgr[3 * column + 2 - channel] = curve_[static_cast<std::size_t>(static_cast<int>(level))];
      sum += std::min(electrons, full_scale);
    }
  }
  return static_cast<double>(sum / full_scale) / (3.0 * params_.width_px);
}

void ImageSensor::adaptExposure(double mean_signal) {
  const double wanted = params_.exposure_target / std::max(mean_signal, 1e-6);
  const double step = std::pow(std::clamp(wanted, 1.0 / kLargestStep, kLargestStep), kDamping);
  const double product = exposure_.time_s * exposure_.gain * step;
  exposure_.time_s = std::clamp(product, params_.shortest_exposure_s, params_.longest_exposure_s);
  exposure_.gain = std::clamp(product / exposure_.time_s, 1.0, params_.gain_limit);
}

}  // namespace frugal_nav::sim
