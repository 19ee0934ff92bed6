#pragma once

#include "image_sensor.hpp"
#include "lens.hpp"
#include "renderer.hpp"
#include "worker_pool.hpp"

#include <cstdint>

#include <frugal_nav/sim/camera.hpp>

namespace frugal_nav::sim {

/// What a camera is made of; the RGB-D camera reads depth from `light` after a render.
struct Camera::Impl {
  Impl(const CameraParams& params_in, std::uint64_t seed)
      : params(params_in), lens(params_in), sensor(params_in, seed), pool(params_in.threads) {}

  CameraImage render(const View& view, const Eigen::Isometry3d& at_open, const Eigen::Isometry3d& at_close,
                     bool with_depth, Stamp stamp);

  CameraParams params;
  Lens lens;
  ImageSensor sensor;
  WorkerPool pool;
  LightImage light;
};

}  // namespace frugal_nav::sim
