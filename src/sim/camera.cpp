#include "camera_impl.hpp"
#include "motion_smear.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <frugal_nav/sim/camera.hpp>

namespace frugal_nav::sim {
namespace {

constexpr double kNearThings_m = 1.0;      // distance at which the blur of a translation is judged
constexpr double kSampleSpacing_px = 1.0;  // instants closer than this cannot be told apart in the image

Eigen::Isometry3d between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double share) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = (1.0 - share) * a.translation() + share * b.translation();
  pose.linear() =
      Eigen::Quaterniond(a.linear()).slerp(share, Eigen::Quaterniond(b.linear())).toRotationMatrix();
  return pose;
}

/// How far the picture moves while the shutter is open [px].
double motionOf(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double focal_px) {
  const double angle = Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
  return focal_px * (std::abs(angle) + (b.translation() - a.translation()).norm() / kNearThings_m);
}

/// The poses whose views are averaged: evenly spread over the exposure.
std::vector<Eigen::Isometry3d> instants(const CameraParams& params, const Eigen::Isometry3d& at_open,
                                        const Eigen::Isometry3d& at_close, double focal_px) {
  int count = 1;
  if (params.motion_blur) {
    const double wanted = std::ceil(motionOf(at_open, at_close, focal_px) / kSampleSpacing_px);
    count = static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(params.blur_samples)));
  }
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < count; ++i) poses.push_back(between(at_open, at_close, (i + 0.5) / count));
  return poses;
}

/// Checks before the parts are built from the parameters.
const CameraParams& checked(const CameraParams& params) {
  validate(params, "camera");
  return params;
}

}  // namespace

CameraImage Camera::Impl::render(const View& view, const Eigen::Isometry3d& at_open,
                                 const Eigen::Isometry3d& at_close, bool with_depth, Stamp stamp) {
  const double focal_px = static_cast<double>(lens.focal_px());
  const std::vector<Eigen::Isometry3d> poses = instants(params, at_open, at_close, focal_px);
  renderLight(view, poses, with_depth || poses.size() > 1, pool, light);
  smearAlongMotion(lens, poses, pool, light);
  return {stamp, sensor.read(light.light_lx, pool)};
}

Camera::Camera(const CameraParams& params, std::uint64_t seed)
    : impl_(std::make_unique<Impl>(checked(params), seed)) {}

Camera::~Camera() = default;
Camera::Camera(Camera&&) noexcept = default;
Camera& Camera::operator=(Camera&&) noexcept = default;

CameraImage Camera::render(const RayTracer& tracer, const Lighting& lighting,
                           const Eigen::Isometry3d& world_from_optical_at_open,
                           const Eigen::Isometry3d& world_from_optical_at_close, Stamp stamp) {
  return impl_->render({tracer, lighting, impl_->lens}, world_from_optical_at_open,
                       world_from_optical_at_close, false, stamp);
}

double Camera::exposureTime_s() const { return impl_->sensor.exposure().time_s; }
double Camera::gain() const { return impl_->sensor.exposure().gain; }
cv::Matx33d Camera::cameraMatrix() const { return impl_->lens.matrix(); }
const CameraParams& Camera::params() const { return impl_->params; }
cv::Vec<double, 5> Camera::distortion() const {
  const CameraParams& p = impl_->params;
  return {p.k1, p.k2, p.p1, p.p2, p.k3};
}

}  // namespace frugal_nav::sim
