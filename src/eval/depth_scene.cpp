#include "depth_scene.hpp"

#include "furniture.hpp"
#include "random_paint.hpp"

#include <algorithm>
#include <cmath>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/sim/primitive_mesh.hpp>

namespace frugal_nav::eval {
namespace {

using Maker = Furniture (*)(Random&);
struct Kind {
  const char* name;
  Maker make;
};

Furniture makeBox(Random& random) {
  Furniture box;
  box.kind = "box";
  box.size_m = {random.uniform(0.15, 0.7), random.uniform(0.15, 0.5)};
  Part part;
  part.outline.size_m = box.size_m;
  part.height_m = random.uniform(0.2, 1.2);
  box.parts.push_back(part);
  return box;
}

// The chair stands in the background only: what lies behind shows through its legs, so that it has no one
// depth.
constexpr Kind kKinds[] = {{"box", makeBox}, {"cabinet", makeCabinet}, {"carton", makeCarton},
                           {"bin", makeBin}, {"pillar", makePillar},   {"chair", makeChair}};
constexpr int kSolidKinds = 5;

class Builder {
 public:
  Builder(std::uint64_t seed, const std::vector<sim::Texture>& textures)
      : random_(seed, "depth scene"), textures_(textures) {}

  DepthScene build(double distance_m, double camera_x_m) {
    drawRoom(distance_m);
    addLights();
    const Kind& kind = kKinds[static_cast<std::size_t>(random_.integer(0, kSolidKinds - 1))];
    place_.object = kind.name;
    place_.light =
        std::vector<std::string>{"daylight", "dim", "tube"}[static_cast<std::size_t>(random_.integer(0, 2))];
    const double bearing = random_.uniform(-0.2, 0.2);
    place_.object_model =
        addThing(kind.make(random_), {camera_x_m + distance_m, 0.0}, distance_m * std::tan(bearing));
    addBackground(distance_m);
    drawDrive();
    return std::move(place_);
  }

 private:
  sim::Scene& scene() { return place_.scene; }

  void addSlab(const Eigen::Vector3d& size_m, const Eigen::Vector3d& middle_m, const Paint& paint) {
    sim::Mesh mesh = sim::makeBox(size_m);
    wear(paint,
         {std::max(size_m.x(), size_m.y()),
          std::min(std::max(size_m.y(), size_m.z()), size_m.z() + size_m.y())},
         mesh);
    sim::Model model;
    model.name = "room";
    model.world_from_model.translation() = middle_m;
    model.visuals.push_back({static_cast<int>(scene().meshes.size()), Eigen::Isometry3d::Identity()});
    scene().meshes.push_back(std::move(mesh));
    scene().models.push_back(std::move(model));
  }

  /// The robot ends at the origin and looks along x.
  void drawRoom(double distance_m) {
    constexpr double kThick_m = 0.1;
    const double back = -random_.uniform(2.0, 3.0);
    front_m_ = distance_m + random_.uniform(1.2, 3.5);
    right_m_ = -random_.uniform(1.4, 3.0);
    left_m_ = random_.uniform(1.4, 3.0);
    height_m_ = random_.uniform(2.3, 3.2);
    const Eigen::Vector3d size(front_m_ - back, left_m_ - right_m_, height_m_);
    const Eigen::Vector3d middle(0.5 * (front_m_ + back), 0.5 * (left_m_ + right_m_), 0.5 * height_m_);
    floor_ = drawPaint(textures_, random_, scene());
    const Paint walls = drawPaint(textures_, random_, scene());
    const Paint ceiling = drawPaint(textures_, random_, scene());
    addSlab({size.x(), size.y(), kThick_m}, {middle.x(), middle.y(), -0.5 * kThick_m}, floor_);
    addSlab({size.x(), size.y(), kThick_m}, {middle.x(), middle.y(), height_m_ + 0.5 * kThick_m}, ceiling);
    addSlab({kThick_m, size.y(), size.z()}, {front_m_ + 0.5 * kThick_m, middle.y(), middle.z()}, walls);
    addSlab({kThick_m, size.y(), size.z()}, {back - 0.5 * kThick_m, middle.y(), middle.z()}, walls);
    addSlab({size.x(), kThick_m, size.z()}, {middle.x(), left_m_ + 0.5 * kThick_m, middle.z()}, walls);
    addSlab({size.x(), kThick_m, size.z()}, {middle.x(), right_m_ - 0.5 * kThick_m, middle.z()}, walls);
  }

  void addLights() {
    sim::Light sun;
    sun.kind = sim::Light::Kind::kDirectional;
    const double azimuth = random_.uniform(-M_PI, M_PI);
    sun.direction = Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), -1.0).normalized();
    sun.casts_shadows = false;  // it stands for the sky through the windows
    scene().lights.push_back(sun);
    for (int i = 0; i < 2; ++i) {
      sim::Light lamp;
      lamp.position_m << random_.uniform(-1.0, front_m_ - 0.5),
          random_.uniform(right_m_ + 0.4, left_m_ - 0.4), height_m_ - 0.3;
      lamp.attenuation_constant = 0.3;
      lamp.attenuation_linear = 0.1;
      lamp.attenuation_quadratic = 0.1;
      scene().lights.push_back(lamp);
    }
  }

  /// Puts a piece with its nearest side at x, as it is turned; the index of its model.
  int addThing(const Furniture& piece, const Eigen::Vector2d& front, double y_m) {
    const double yaw = random_.uniform(-0.6, 0.6);
    const Eigen::Vector2d half = 0.5 * piece.size_m;
    const double reach = half.x() * std::abs(std::cos(yaw)) + half.y() * std::abs(std::sin(yaw));
    const std::size_t first_mesh = scene().meshes.size();
    std::vector<Solid> solids;
    place(piece, {front.x() + reach, y_m, yaw}, piece.kind, scene(), solids);
    const Paint look = drawPaint(textures_, random_, scene());
    for (std::size_t m = first_mesh; m < scene().meshes.size(); ++m)
      wear(look, {0.6, 0.6}, scene().meshes[m]);
    return static_cast<int>(scene().models.size()) - 1;
  }

  /// Things farther away and to the sides, out of the drive's way.
  void addBackground(double distance_m) {
    const int count = random_.integer(1, 4);
    for (int i = 0; i < count; ++i) {
      const Kind& kind = kKinds[static_cast<std::size_t>(random_.integer(0, std::size(kKinds) - 1))];
      const double x = distance_m + random_.uniform(0.9, std::max(1.0, front_m_ - distance_m - 0.3));
      addThing(kind.make(random_), {x, 0.0}, random_.uniform(right_m_ + 0.4, left_m_ - 0.4));
    }
  }

  void drawDrive() {
    const double turn = (random_.chance(0.5) ? 1.0 : -1.0) * random_.uniform(0.25, 0.45);
    place_.legs = {{0.3, turn}, {0.4, -turn}, {0.35, 0.0}};
    Pose2 end;
    for (const DriveLeg& leg : place_.legs) end = end * Pose2{leg.length_m, 0.0, leg.turn_rad};
    place_.start = end.inverse();
  }

  Random random_;
  const std::vector<sim::Texture>& textures_;
  DepthScene place_;
  Paint floor_;
  double front_m_ = 0.0;
  double left_m_ = 0.0;
  double right_m_ = 0.0;
  double height_m_ = 0.0;
};

}  // namespace

DepthScene makeDepthScene(std::uint64_t seed, double distance_m, double camera_x_m,
                          const std::vector<sim::Texture>& textures) {
  return Builder(seed, textures).build(distance_m, camera_x_m);
}

}  // namespace frugal_nav::eval
