#include "localization_course.hpp"

#include <cmath>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/eval/statistics.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kClearance_m = 0.32;  // half the robot's width, and room for the slip of its wheels
constexpr double kAhead_m = 0.9;       // to what the camera looks at when a straight ends

bool hasAirAround(const sim::RayTracer& tracer, const Eigen::Vector2d& p) {
  constexpr int kDirections = 16;
  for (const double height_m : {0.04, 0.2, 0.42}) {
    for (int i = 0; i < kDirections; ++i) {
      const double angle = 2.0 * M_PI * i / kDirections;
      const Eigen::Vector3d origin(p.x(), p.y(), height_m);
      if (tracer.range(origin, {std::cos(angle), std::sin(angle), 0.0}, kClearance_m)) return false;
    }
  }
  // Inside a closed thing there is air too, but no floor below.
  const auto below = tracer.range({p.x(), p.y(), 0.42}, -Eigen::Vector3d::UnitZ(), 1.0);
  return below && std::abs(*below - 0.42) < 0.02;
}

bool isFree(const sim::RayTracer& tracer, const Course& course) {
  constexpr double kStep_m = 0.1;
  Pose2 pose = course.start;
  for (const DriveLeg& leg : course.legs) {
    for (double along_m = 0.0; along_m <= leg.length_m; along_m += kStep_m) {
      if (!hasAirAround(tracer, (pose * Pose2{along_m, 0.0, 0.0}).position())) return false;
    }
    pose = pose * Pose2{leg.length_m, 0.0, 0.0};
    const Eigen::Vector3d eye(pose.x_m, pose.y_m, 0.4);
    if (tracer.range(eye, {std::cos(pose.yaw_rad), std::sin(pose.yaw_rad), 0.0}, kAhead_m)) return false;
    pose = pose * Pose2{0.0, 0.0, leg.turn_rad};
  }
  return true;
}

std::vector<DriveLeg> drawCorner(Random& random) {
  const double first_m = random.uniform(2.0, 3.5);
  return {{first_m, -M_PI_2}, {random.uniform(1.5, 3.0), 0.0}};
}

std::vector<DriveLeg> drawSquare(Random& random) {
  const double side_m = random.uniform(1.0, 2.0);
  return std::vector<DriveLeg>(4, {side_m, random.chance(0.5) ? M_PI_2 : -M_PI_2});
}

/// Places a course where it fits.
std::optional<Course> drawCourse(const Eigen::AlignedBox2d& floor, const sim::RayTracer& tracer,
                                 std::vector<DriveLeg> (*draw)(Random&), Random& random) {
  constexpr int kAttempts = 400;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Course course;
    course.start.x_m = random.uniform(floor.min().x(), floor.max().x());
    course.start.y_m = random.uniform(floor.min().y(), floor.max().y());
    course.start.yaw_rad = random.uniform(-M_PI, M_PI);
    course.legs = draw(random);
    if (isFree(tracer, course)) return course;
  }
  return std::nullopt;
}

Eigen::AlignedBox2d floorOf(const sim::Scene& scene) {
  Eigen::AlignedBox2d floor;
  for (const sim::Model& model : scene.models) {
    if (model.name != "floor") continue;
    for (const sim::Visual& visual : model.visuals) {
      for (const Eigen::Vector3f& vertex : scene.meshes[static_cast<std::size_t>(visual.mesh)].vertices)
        floor.extend(Eigen::Vector2d(
            (model.world_from_model * visual.model_from_visual * vertex.cast<double>()).head<2>()));
    }
  }
  return floor;
}

}  // namespace

LocalizationPlace drawLocalizationPlace(std::uint64_t seed, const TrainingStock& stock) {
  Random random(seed, "localization");
  constexpr int kRooms = 40;
  for (int attempt = 0; attempt < kRooms; ++attempt) {
    LocalizationPlace place;
    Eigen::AlignedBox2d floor;
    if (seed % 2 == 0) {
      place.scene = stock.worlds.front();
      place.scene.people.clear();
      floor = floorOf(place.scene);
    } else {
      TrainingScene room =
          makeUnseenScene(static_cast<std::uint64_t>(random.integer(0, 99999)), stock, false);
      floor = room.floor;
      place.scene = std::move(room.scene);
    }
    const sim::RayTracer tracer(place.scene);
    const auto corner = drawCourse(floor, tracer, drawCorner, random);
    const auto square = corner ? drawCourse(floor, tracer, drawSquare, random) : std::nullopt;
    if (!square) continue;
    place.corner = *corner;
    place.square = *square;
    return place;
  }
  throw ConfigError("seed " + std::to_string(seed) + ": no room drawn has space for the courses");
}

std::optional<double> meanDistanceToSurface(const std::vector<Eigen::Vector3f>& points,
                                            const sim::RayTracer& tracer) {
  // Rays all around: the nearest hit lies at most 1/cos(10 degrees), 1.5 %, beyond the nearest surface of a
  // wall.
  constexpr int kDirections = 200;
  constexpr double kFarthest_m = 3.0;
  const double golden_rad = M_PI * (3.0 - std::sqrt(5.0));
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections;
    const double across = std::sqrt(1.0 - z * z);
    directions.emplace_back(across * std::cos(golden_rad * i), across * std::sin(golden_rad * i), z);
  }
  std::vector<double> distances;
  for (const Eigen::Vector3f& p : points) {
    double nearest_m = kFarthest_m;
    for (const Eigen::Vector3d& direction : directions) {
      const auto range = tracer.range(p.cast<double>(), direction, nearest_m);
      if (range) nearest_m = *range;
    }
    distances.push_back(nearest_m);
  }
  return mean(distances);
}

}  // namespace frugal_nav::eval
