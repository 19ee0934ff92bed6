#include "detector_view.hpp"

#include <algorithm>
#include <cmath>

#include <frugal_nav/eval/visual_drive.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kLeastOverlap = 0.5;

/// The exposure that the automatic settles at, measured by a tiny image of the same view, so that the first
/// image is exposed as the hundredth.
sim::CameraParams exposed(sim::CameraParams params, const Eigen::Isometry3d& pose,
                          const sim::RayTracer& tracer, const sim::Lighting& lighting, std::uint64_t seed) {
  constexpr int kMeterWidth_px = 48;
  constexpr int kMeterFrames = 5;
  sim::CameraParams meter_params = params;
  meter_params.width_px = kMeterWidth_px;
  meter_params.height_px = 3 * kMeterWidth_px / 4;
  sim::Camera meter(meter_params, seed);
  for (int i = 0; i < kMeterFrames; ++i) meter.render(tracer, lighting, pose, pose, Stamp{});
  params.shortest_exposure_s = params.longest_exposure_s = meter.exposureTime_s();
  params.full_well_e /= meter.gain();  // a new camera's gain is one: the same full scale in electrons
  return params;
}

sim::LightingParams lightOf(const std::string& setting) {
  sim::LightingParams params;
  params.setting = setting;
  return params;
}

/// The camera on a robot that creeps and sways.
Eigen::Isometry3d swayed(const Eigen::Isometry3d& pose, Random& random) {
  constexpr double kAlong_m = 0.01;
  constexpr double kYaw_rad = 0.01;
  constexpr double kTilt_rad = 0.002;
  Eigen::Isometry3d moved = pose;
  moved.translation().x() += random.normal(kAlong_m);
  moved.translation().y() += random.normal(kAlong_m);
  // About the axes of the optical frame: x is to the right, y down, z ahead.
  moved.linear() = moved.linear() * (Eigen::AngleAxisd(random.normal(kTilt_rad), Eigen::Vector3d::UnitX()) *
                                     Eigen::AngleAxisd(random.normal(kYaw_rad), Eigen::Vector3d::UnitY()) *
                                     Eigen::AngleAxisd(random.normal(kTilt_rad), Eigen::Vector3d::UnitZ()))
                                        .toRotationMatrix();
  return moved;
}

}  // namespace

std::optional<DetectorView> DetectorView::draw(const TrainingScene& place, const sim::RayTracer& tracer,
                                               const Eigen::Isometry3d& base_from_optical, int width_px,
                                               bool heads, std::uint64_t seed, int number) {
  Random random(seed, "detector view " + std::to_string(number));
  const std::string light =
      std::vector<std::string>{"daylight", "dim", "tube"}[static_cast<std::size_t>(random.integer(0, 2))];
  sim::CameraParams camera;
  camera.width_px = width_px;
  camera.height_px = 3 * width_px / 4;
  camera.motion_blur = false;
  camera.threads = 1;  // scenes are rendered side by side
  const double ahead_up = base_from_optical.linear()(2, 2);
  const auto pose = drawHeadView(place, tracer, base_from_optical.translation().z(), std::asin(ahead_up),
                                 camera.horizontal_fov_rad, random);
  if (!pose) return std::nullopt;
  return DetectorView(place, tracer, *pose, camera, light, heads,
                      seed + 1000000 * static_cast<std::uint64_t>(number), random);
}

DetectorView::DetectorView(const TrainingScene& place, const sim::RayTracer& tracer,
                           const Eigen::Isometry3d& pose, const sim::CameraParams& camera,
                           const std::string& light, bool heads, std::uint64_t seed, const Random& random)
    : place_(place),
      tracer_(tracer),
      world_from_optical_(pose),
      light_(light),
      heads_(heads),
      lighting_(lightOf(light), tracer, seed),
      camera_(exposed(camera, pose, tracer, lighting_, seed), seed),
      random_(random) {}

DetectorView::Frame DetectorView::next() {
  const Eigen::Isometry3d pose = is_first_ ? world_from_optical_ : swayed(world_from_optical_, random_);
  is_first_ = false;
  const Viewpoint viewpoint{{camera_.params().width_px, camera_.params().height_px},
                            camera_.cameraMatrix(),
                            camera_.distortion(),
                            pose};
  Frame frame;
  frame.bgr = camera_.render(tracer_, lighting_, pose, pose, Stamp{}).bgr;
  for (const PersonBox& box :
       findPeople(traceTruth(tracer_, viewpoint), place_.scene, place_.people, viewpoint)) {
    if (box.is_head == heads_) frame.truth.push_back(box);
  }
  return frame;
}

Pinhole DetectorView::pinhole() const { return pinholeOf(camera_); }

std::vector<int> matchBoxes(const std::vector<Detection>& detections, const std::vector<PersonBox>& truth) {
  std::vector<int> found;
  std::vector<bool> is_taken(truth.size(), false);
  for (const Detection& detection : detections) {
    int best = -1;
    double most = kLeastOverlap;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const double overlap = boxOverlap(detection.box, truth[i].box_px);
      if (is_taken[i] || overlap < most) continue;
      most = overlap;
      best = static_cast<int>(i);
    }
    if (best >= 0) is_taken[static_cast<std::size_t>(best)] = true;
    found.push_back(best);
  }
  return found;
}

double boxOverlap(const cv::Rect2d& a, const cv::Rect2d& b) {
  const double both = (a & b).area();
  const double either = a.area() + b.area() - both;
  return either > 0.0 ? both / either : 0.0;
}

std::optional<double> averagePrecision(std::vector<JudgedDetection> detections, int targets) {
  if (targets <= 0) return std::nullopt;
  std::stable_sort(detections.begin(), detections.end(),
                   [](const JudgedDetection& a, const JudgedDetection& b) { return a.score > b.score; });
  std::vector<double> precision;
  int hits = 0;
  for (const JudgedDetection& detection : detections) {
    hits += detection.is_hit ? 1 : 0;
    precision.push_back(static_cast<double>(hits) / static_cast<double>(precision.size() + 1));
  }
  // The best precision at this recall or beyond; each hit is a step of recall.
  double best = 0.0;
  double area = 0.0;
  for (std::size_t i = precision.size(); i-- > 0;) {
    best = std::max(best, precision[i]);
    if (detections[i].is_hit) area += best / targets;
  }
  return area;
}

}  // namespace frugal_nav::eval
