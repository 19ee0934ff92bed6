#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/sim/camera.hpp>
#include <frugal_nav/sim/lighting.hpp>
#include <frugal_nav/sim/people.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>
#include <frugal_nav/sim/scene.hpp>

namespace frugal_nav::eval {

/// The lowest seed of a training scene: evaluation draws below 100,000, tuning from 500,000 to 999,999, so
/// that no network ever learns a scene that it is measured on.
constexpr std::uint64_t kFirstTrainingSeed = 1000000;

/// What training scenes are made of: textures, pieces of furniture, whole worlds.
struct TrainingStock {
  std::vector<sim::Texture> textures;
  std::vector<sim::Scene> worlds;
  /// Furniture of the worlds: index of the world and of its model.
  std::vector<std::pair<std::size_t, std::size_t>> furniture;
};

/// Reads the textures and worlds of the package's folder `worlds`. Throws ConfigError when they are missing.
TrainingStock readTrainingStock(const std::string& worlds_folder);

/// A random place to look at.
struct TrainingScene {
  sim::Scene scene;
  std::vector<sim::PersonBody> people;
  std::vector<Eigen::Vector2d> objects;  ///< where the things stand that were put there [m]
  Eigen::AlignedBox2d floor;             ///< [m]
};

/// Draws rooms, and sometimes a shipped world, with things, people and lamps of all kinds. The same seed
/// gives the same scene. Throws ConfigError for a seed below kFirstTrainingSeed.
TrainingScene makeTrainingScene(std::uint64_t seed, const TrainingStock& stock);

/// A scene of the same kind for evaluation or tuning: neither room, things nor people are those of a training
/// scene. Throws ConfigError for a seed from kFirstTrainingSeed on.
TrainingScene makeUnseenScene(std::uint64_t seed, const TrainingStock& stock, bool with_people = true);

/// A camera in a training scene.
struct TrainingView {
  Eigen::Isometry3d world_from_optical = Eigen::Isometry3d::Identity();
  double camera_height_m = 0.4;
  double pitch_rad = 0.0;  ///< up is positive
  sim::CameraParams camera;
  sim::LightingParams lighting;
};

/// Draws a view of a person, of a thing or of anywhere, from where nothing is nearer than 0.25 m. Nothing
/// when no such place is found.
std::optional<TrainingView> drawTrainingView(const TrainingScene& place, const sim::RayTracer& tracer,
                                             int width_px, Random& random);

/// Draws a pose of a given camera, mounted that high and pitched that much, from which a head is in sight, 2
/// to 6 m away on the ground and likely whole. Nothing when no such place is found.
std::optional<Eigen::Isometry3d> drawHeadView(const TrainingScene& place, const sim::RayTracer& tracer,
                                              double camera_height_m, double pitch_rad, double fov_rad,
                                              Random& random);

}  // namespace frugal_nav::eval
