#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Geometry>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/sim/camera.hpp>
#include <frugal_nav/sim/sensor_data.hpp>

namespace frugal_nav::sim {

/// A colour-and-depth camera of the structured-light kind, both images through one lens.
struct RgbdParams {
  CameraParams color = defaultColor();
  double depth_min_m = 0.4;
  double depth_max_m = 6.0;
  double sigma_a_m = 0.0012;
  double sigma_b_per_m = 0.0019;
  double edge_jump_ratio = 0.05;
  double grazing_cos = 0.15;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("color", color);
    visit("depth_min_m", depth_min_m, Field{"m", "nearest depth measured; nearer is a hole", 0.0, 5.0});
    visit("depth_max_m", depth_max_m, Field{"m", "farthest depth measured; farther is a hole", 0.1, 50.0});
    visit("sigma_a_m", sigma_a_m,
          Field{"m", "constant part of the depth's standard deviation a + b z^2 (Nguyen et al. 2012)", 0.0,
                0.1});
    visit("sigma_b_per_m", sigma_b_per_m,
          Field{"1/m", "quadratic part of the depth's standard deviation: triangulation's", 0.0, 0.1});
    visit("edge_jump_ratio", edge_jump_ratio,
          Field{"",
                "jump to a neighbouring pixel, over depth, that leaves a hole: the pattern is shadowed there",
                0.001, 10.0});
    visit("grazing_cos", grazing_cos,
          Field{"", "cosine of incidence below which a surface returns no depth", 0.0, 1.0});
  }
  std::string check() const {
    return depth_min_m < depth_max_m ? "" : "depth_min_m must be less than depth_max_m";
  }
  static CameraParams defaultColor();
};

/// What an RGB-D camera gives at one instant.
struct RgbdImages {
  CameraImage color;
  DepthImage depth;  ///< the same size, lens and frame as `color`
};

/// A colour-and-depth camera in a ray-traced scene. Depth is measured half way through the exposure.
class RgbdCamera {
 public:
  /// Throws ConfigError on parameters out of range.
  RgbdCamera(const RgbdParams& params, std::uint64_t seed);

  /// One pair of images; poses as for Camera::render.
  RgbdImages render(const RayTracer& tracer, const Lighting& lighting,
                    const Eigen::Isometry3d& world_from_optical_at_open,
                    const Eigen::Isometry3d& world_from_optical_at_close, Stamp stamp);

  /// Lens, exposure time and gain: of both images.
  const Camera& camera() const { return camera_; }
  const RgbdParams& params() const { return params_; }

 private:
  RgbdParams params_;
  Camera camera_;
  std::uint64_t seed_;
  std::uint64_t frame_ = 0;
};

}  // namespace frugal_nav::sim
