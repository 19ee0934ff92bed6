#include "camera_impl.hpp"
#include "fast_noise.hpp"

#include <cmath>
#include <limits>

#include <frugal_nav/sim/rgbd_camera.hpp>

namespace frugal_nav::sim {
namespace {

constexpr std::uint64_t kDepthStream = 0x64657074ULL;  // keeps depth noise apart from the colour image's

const RgbdParams& checked(const RgbdParams& params) {
  validate(params, "RGB-D camera");
  return params;
}

/// True depth and incidence at a pixel and around it.
class DepthView {
 public:
  DepthView(const LightImage& image, int width, int height) : image_(image), width_(width), height_(height) {}

  float at(int column, int row) const { return image_.depth_m[index(column, row)]; }
  float cosAt(int column, int row) const { return image_.cos_incidence[index(column, row)]; }

  /// The largest step to one of the four neighbours [m].
  float largestJump(int column, int row) const {
    const float here = at(column, row);
    float jump = 0.0F;
    if (column > 0) jump = std::max(jump, std::abs(at(column - 1, row) - here));
    if (column + 1 < width_) jump = std::max(jump, std::abs(at(column + 1, row) - here));
    if (row > 0) jump = std::max(jump, std::abs(at(column, row - 1) - here));
    if (row + 1 < height_) jump = std::max(jump, std::abs(at(column, row + 1) - here));
    return jump;
  }

 private:
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(column);
  }
  const LightImage& image_;
  int width_;
  int height_;
};

}  // namespace

CameraParams RgbdParams::defaultColor() {
  CameraParams color;
  color.horizontal_fov_rad = 1.0123;
  color.k1 = color.k2 = color.p1 = color.p2 = color.k3 = 0.0;
  return color;
}

RgbdCamera::RgbdCamera(const RgbdParams& params, std::uint64_t seed)
    : params_(checked(params)), camera_(params.color, seed), seed_(seed ^ kDepthStream) {}

RgbdImages RgbdCamera::render(const RayTracer& tracer, const Lighting& lighting,
                              const Eigen::Isometry3d& world_from_optical_at_open,
                              const Eigen::Isometry3d& world_from_optical_at_close, Stamp stamp) {
  Camera::Impl& eye = *camera_.impl_;
  RgbdImages images;
  images.color = eye.render({tracer, lighting, eye.lens}, world_from_optical_at_open,
                            world_from_optical_at_close, true, stamp);
  const int width = params_.color.width_px;
  const int height = params_.color.height_px;
  const DepthView truth(eye.light, width, height);
  const auto nearest = static_cast<float>(params_.depth_min_m);
  const auto farthest = static_cast<float>(params_.depth_max_m);
  const auto jump_ratio = static_cast<float>(params_.edge_jump_ratio);
  const auto grazing = static_cast<float>(params_.grazing_cos);
  const auto a = static_cast<float>(params_.sigma_a_m);
  const auto b = static_cast<float>(params_.sigma_b_per_m);
  images.depth.stamp = stamp;
  images.depth.depth_m =
      cv::Mat(height, width, CV_32FC1, cv::Scalar(std::numeric_limits<double>::quiet_NaN()));
  for (int row = 0; row < height; ++row) {
    FastNoise noise(seed_, frame_, static_cast<std::uint64_t>(row));
    auto* out = images.depth.depth_m.ptr<float>(row);
    for (int column = 0; column < width; ++column) {
      const float gauss = noise.gauss();
      const float z = truth.at(column, row);
      if (!(z >= nearest && z <= farthest)) continue;
      if (truth.cosAt(column, row) < grazing || truth.largestJump(column, row) > jump_ratio * z) continue;
      out[column] = z + (a + b * z * z) * gauss;
    }
  }
  ++frame_;
  return images;
}

}  // namespace frugal_nav::sim
