#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/sim/lighting.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>
#include <frugal_nav/sim/sensor_data.hpp>

namespace frugal_nav::sim {

/// A colour camera; the defaults are a Raspberry Pi camera's at 640x480.
struct CameraParams {
  int width_px = 640;
  int height_px = 480;
  double horizontal_fov_rad = 1.0821;
  double k1 = 0.10;
  double k2 = -0.22;
  double p1 = 0.0005;
  double p2 = -0.0005;
  double k3 = 0.05;
  double rate_hz = 10.0;
  double exposure_target = 0.18;
  double longest_exposure_s = 0.033;
  double shortest_exposure_s = 0.0001;
  double gain_limit = 8.0;
  double electrons_per_lx_s = 1200.0;
  double full_well_e = 12000.0;
  double read_noise_e = 3.0;
  bool shot_noise = true;
  bool motion_blur = true;
  int blur_samples = 3;
  int threads = 2;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("width_px", width_px, Field{"px", "columns of the image", 16, 4096});
    visit("height_px", height_px, Field{"px", "rows of the image", 16, 4096});
    visit("horizontal_fov_rad", horizontal_fov_rad,
          Field{"rad", "width of the view, before distortion", 0.1, 2.8});
    visit("k1", k1, Field{"", "plumb-bob radial distortion, r^2", -1.0, 1.0});
    visit("k2", k2, Field{"", "plumb-bob radial distortion, r^4", -1.0, 1.0});
    visit("p1", p1, Field{"", "plumb-bob tangential distortion", -0.1, 0.1});
    visit("p2", p2, Field{"", "plumb-bob tangential distortion", -0.1, 0.1});
    visit("k3", k3, Field{"", "plumb-bob radial distortion, r^6", -1.0, 1.0});
    visit("rate_hz", rate_hz, Field{"Hz", "images a second", 0.1, 90.0});
    visit("exposure_target", exposure_target,
          Field{"", "mean signal the automatic exposure aims at, as a share of full scale", 0.01, 0.9});
    visit("longest_exposure_s", longest_exposure_s,
          Field{"s", "limit of the exposure time: beyond it the gain rises, then the image darkens", 1e-5,
                1.0});
    visit("shortest_exposure_s", shortest_exposure_s,
          Field{"s", "shortest time the shutter can be open", 1e-6, 1.0});
    visit("gain_limit", gain_limit, Field{"", "largest analogue gain", 1.0, 64.0});
    visit("electrons_per_lx_s", electrons_per_lx_s,
          Field{"1/(lx s)", "electrons a pixel collects of a white surface, by its illuminance and the time",
                1.0, 1e6});
    visit("full_well_e", full_well_e, Field{"", "electrons at full scale with a gain of one", 100.0, 1e6});
    visit("read_noise_e", read_noise_e,
          Field{"", "standard deviation of the read-out, in electrons", 0.0, 100.0});
    visit("shot_noise", shot_noise, Field{"", "whether the electrons' number varies by its square root"});
    visit("motion_blur", motion_blur,
          Field{"", "whether the camera's motion while the shutter is open blurs"});
    visit(
        "blur_samples", blur_samples,
        Field{"",
              "most instants traced over the exposure; they are joined into a smear; fewer for small motions",
              1, 16});
    visit("threads", threads, Field{"", "threads that render; the image does not depend on it", 1, 64});
  }
  std::string check() const {
    return shortest_exposure_s <= longest_exposure_s
               ? ""
               : "shortest_exposure_s must not exceed longest_exposure_s";
  }
};

/// A colour camera in a ray-traced scene: lens, auto-exposure, noise and motion blur. Poses are of the
/// optical frame (x right, y down, z ahead; REP-103).
class Camera {
 public:
  /// Throws ConfigError on parameters out of range or a distortion that folds the image.
  Camera(const CameraParams& params, std::uint64_t seed);
  ~Camera();
  Camera(Camera&&) noexcept;
  Camera& operator=(Camera&&) noexcept;

  /// One image, exposed for exposureTime_s() between the two poses. Without motion blur it shows what is seen
  /// half way. Then the exposure of the next image is chosen.
  CameraImage render(const RayTracer& tracer, const Lighting& lighting,
                     const Eigen::Isometry3d& world_from_optical_at_open,
                     const Eigen::Isometry3d& world_from_optical_at_close, Stamp stamp);

  /// The exposure time of the next image, from the images so far [s].
  double exposureTime_s() const;
  /// The analogue gain of the next image.
  double gain() const;
  /// 3x3 matrix of fx, fy, cx, cy [px]; pixel centres have integer coordinates, as in OpenCV.
  cv::Matx33d cameraMatrix() const;
  /// Plumb-bob coefficients k1, k2, p1, p2, k3.
  cv::Vec<double, 5> distortion() const;
  const CameraParams& params() const;

 private:
  friend class RgbdCamera;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace frugal_nav::sim
