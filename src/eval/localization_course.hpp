#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/eval/training_scene.hpp>
#include <frugal_nav/eval/visual_drive.hpp>

namespace frugal_nav::eval {

/// A way to drive in a scene that it fits into.
struct Course {
  Pose2 start;
  std::vector<DriveLeg> legs;
};

/// A scene with two courses in it.
struct LocalizationPlace {
  sim::Scene scene;
  Course corner;  ///< straight, right turn, straight
  Course square;  ///< round a square, to the left or to the right, back to the start
};

/// The package's lab for even seeds, an unseen room for odd ones, and courses drawn in it. The lab is the
/// first of the stock's worlds. Throws ConfigError when no drawn room has space for both.
LocalizationPlace drawLocalizationPlace(std::uint64_t seed, const TrainingStock& stock);

/// Mean distance of points to the nearest surface of a scene [m]; nullopt of none.
std::optional<double> meanDistanceToSurface(const std::vector<Eigen::Vector3f>& points,
                                            const sim::RayTracer& tracer);

}  // namespace frugal_nav::eval
