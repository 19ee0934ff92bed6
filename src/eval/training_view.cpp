#include <algorithm>
#include <cmath>

#include <frugal_nav/eval/training_scene.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kClearance_m = 0.25;
constexpr int kAttempts = 120;

/// Where a camera stands and where it looks, on the floor plan.
struct Stand {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0.0;
  std::optional<Eigen::Vector3d> must_see;  ///< in the world [m]
};

Stand lookAt(const Eigen::Vector2d& target, double nearest_m, double farthest_m, double spread_rad,
             Random& random) {
  const double distance = random.uniform(nearest_m, farthest_m);
  const double direction = random.uniform(-M_PI, M_PI);
  Stand stand;
  stand.position_m = target - distance * Eigen::Vector2d(std::cos(direction), std::sin(direction));
  stand.yaw_rad = direction + random.uniform(-spread_rad, spread_rad);
  return stand;
}

/// A camera at a point that looks along a yaw, pitched up.
Eigen::Isometry3d opticalPose(const Eigen::Vector3d& p, double yaw_rad, double pitch_rad, double roll_rad) {
  Eigen::Matrix3d ahead_from_optical;  // of a camera that looks along x
  ahead_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = p;
  pose.linear() = (Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(-pitch_rad, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix() *
                  ahead_from_optical;
  return pose;
}

/// The middle of somebody's head.
Eigen::Vector3d middleOfHead(const TrainingScene& place, const sim::PersonBody& body) {
  const sim::Model& model = place.scene.models[static_cast<std::size_t>(body.model)];
  const sim::Visual& head = model.visuals[static_cast<std::size_t>(body.head)];
  constexpr double kMiddleOverNeck_m = 0.16;
  return (model.world_from_model * head.model_from_visual).translation() +
         kMiddleOverNeck_m * Eigen::Vector3d::UnitZ();
}

enum class Wish { kHead, kPerson, kThing, kAnything };

Wish drawWish(const TrainingScene& place, Random& random) {
  const double draw = random.uniform(0.0, 1.0);
  if (draw < 0.55 && !place.people.empty()) return draw < 0.45 ? Wish::kHead : Wish::kPerson;
  return draw < 0.85 && !place.objects.empty() ? Wish::kThing : Wish::kAnything;
}

Stand drawStand(const TrainingScene& place, Wish wish, double fov_rad, Random& random) {
  if (wish == Wish::kHead || wish == Wish::kPerson) {
    const auto last = static_cast<int>(place.people.size()) - 1;
    const sim::PersonBody& body = place.people[static_cast<std::size_t>(random.integer(0, last))];
    const Eigen::Vector3d head = middleOfHead(place, body);
    // Nearer than this a standing person's head is above the picture.
    const double nearest_m = wish == Wish::kHead ? 1.6 : 0.8;
    Stand stand = lookAt(head.head<2>(), nearest_m, 7.0, 0.45 * fov_rad, random);
    if (wish == Wish::kHead) stand.must_see = head;
    return stand;
  }
  if (wish == Wish::kThing) {
    const auto last = static_cast<int>(place.objects.size()) - 1;
    return lookAt(place.objects[static_cast<std::size_t>(random.integer(0, last))], 0.6, 3.5, 0.4 * fov_rad,
                  random);
  }
  const Eigen::Vector2d low = place.floor.min();
  const Eigen::Vector2d size = place.floor.sizes();
  Stand stand;
  stand.position_m.x() = low.x() + random.uniform(0.0, 1.0) * size.x();
  stand.position_m.y() = low.y() + random.uniform(0.0, 1.0) * size.y();
  stand.yaw_rad = random.uniform(-M_PI, M_PI);
  return stand;
}

/// Whether a camera has air around it and the floor below.
bool isFree(const TrainingScene& place, const sim::RayTracer& tracer, const Eigen::Vector3d& p) {
  constexpr double kFloorSlack_m = 0.02;
  if (!place.floor.contains(Eigen::Vector2d(p.head<2>()))) return false;
  const auto below = tracer.range(p, -Eigen::Vector3d::UnitZ(), 2.0);
  if (!below || std::abs(*below - p.z()) > kFloorSlack_m) return false;
  constexpr int kDirections = 16;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2.0 * M_PI * i / kDirections;
    if (tracer.range(p, {std::cos(angle), std::sin(angle), 0.0}, kClearance_m)) return false;
  }
  return true;
}

/// Whether there is something to see: no wall right in front, and the wanted head in sight.
bool seesEnough(const sim::RayTracer& tracer, const Eigen::Vector3d& p, const Stand& stand) {
  constexpr double kNearestAhead_m = 0.6;
  if (tracer.range(p, {std::cos(stand.yaw_rad), std::sin(stand.yaw_rad), 0.0}, kNearestAhead_m)) return false;
  if (!stand.must_see) return true;
  constexpr double kHeadRadius_m = 0.15;
  const Eigen::Vector3d line = *stand.must_see - p;
  return !tracer.range(p, line, line.norm() - kHeadRadius_m);
}

sim::CameraParams drawCamera(int width_px, Random& random) {
  sim::CameraParams camera;
  camera.width_px = width_px;
  camera.height_px = 3 * width_px / 4;
  camera.horizontal_fov_rad =
      random.chance(0.4) ? camera.horizontal_fov_rad : random.uniform(50.0, 75.0) * kDegree;
  const double distortion = random.chance(0.4) ? 1.0 : random.uniform(0.0, 1.0);
  for (double* k : {&camera.k1, &camera.k2, &camera.p1, &camera.p2, &camera.k3}) *k *= distortion;
  camera.motion_blur = false;
  camera.threads = 1;
  return camera;
}

sim::LightingParams drawLighting(Random& random) {
  sim::LightingParams lighting;
  const double draw = random.uniform(0.0, 1.0);
  lighting.setting = draw < 0.4 ? "daylight" : (draw < 0.7 ? "dim" : "tube");
  if (random.chance(0.25))
    lighting.illuminance_lx = std::exp(random.uniform(std::log(5.0), std::log(3000.0)));
  lighting.shadow_rays = 1;
  return lighting;
}

}  // namespace

std::optional<TrainingView> drawTrainingView(const TrainingScene& place, const sim::RayTracer& tracer,
                                             int width_px, Random& random) {
  TrainingView view;
  view.camera = drawCamera(width_px, random);
  view.lighting = drawLighting(random);
  // Half of the cameras are about where the shipped robot has its own.
  const bool usual = random.chance(0.5);
  view.camera_height_m = usual ? random.uniform(0.36, 0.44) : random.uniform(0.2, 0.8);
  view.pitch_rad = kDegree * (usual ? random.uniform(2.0, 8.0) : random.uniform(-10.0, 10.0));
  const double roll_rad = kDegree * random.normal(0.7);
  const Wish wish = drawWish(place, random);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Stand stand = drawStand(place, wish, view.camera.horizontal_fov_rad, random);
    const Eigen::Vector3d p(stand.position_m.x(), stand.position_m.y(), view.camera_height_m);
    if (!isFree(place, tracer, p) || !seesEnough(tracer, p, stand)) continue;
    view.world_from_optical = opticalPose(p, stand.yaw_rad, view.pitch_rad, roll_rad);
    return view;
  }
  return std::nullopt;
}

std::optional<Eigen::Isometry3d> drawHeadView(const TrainingScene& place, const sim::RayTracer& tracer,
                                              double camera_height_m, double pitch_rad, double fov_rad,
                                              Random& random) {
  if (place.people.empty()) return std::nullopt;
  const auto last = static_cast<int>(place.people.size()) - 1;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto person = static_cast<std::size_t>(random.integer(0, last));
    const Eigen::Vector3d head = middleOfHead(place, place.people[person]);
    Stand stand = lookAt(head.head<2>(), 2.0, 6.0, 0.4 * fov_rad, random);
    stand.must_see = head;
    const Eigen::Vector3d p(stand.position_m.x(), stand.position_m.y(), camera_height_m);
    if (isFree(place, tracer, p) && seesEnough(tracer, p, stand))
      return opticalPose(p, stand.yaw_rad, pitch_rad, 0.0);
  }
  return std::nullopt;
}

}  // namespace frugal_nav::eval
