#include "furniture.hpp"
#include "random_paint.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/eval/training_scene.hpp>
#include <frugal_nav/sim/primitive_mesh.hpp>
#include <frugal_nav/sim/sdf_world.hpp>

namespace frugal_nav::eval {
namespace {

Eigen::Isometry3d onFloor(const Eigen::Vector2d& p, double yaw_rad, double height_m = 0.0) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << p, height_m;
  pose.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

/// Adds a mesh as a model of its own.
void add(sim::Mesh mesh, const Eigen::Isometry3d& pose, const std::string& name, sim::Scene& scene) {
  sim::Model model;
  model.name = name;
  model.world_from_model = pose;
  model.visuals.push_back({static_cast<int>(scene.meshes.size()), Eigen::Isometry3d::Identity()});
  scene.meshes.push_back(std::move(mesh));
  scene.models.push_back(std::move(model));
}

void addBox(const Eigen::Vector3d& size_m, const Eigen::Isometry3d& pose, const Paint& paint,
            const std::string& name, sim::Scene& scene) {
  sim::Mesh mesh = sim::makeBox(size_m);
  wear(paint, {std::max(size_m.x(), size_m.y()), size_m.z()}, mesh);
  add(std::move(mesh), pose, name, scene);
}

Eigen::AlignedBox3d boundsOf(const sim::Scene& scene, const sim::Model& model) {
  Eigen::AlignedBox3d bounds;
  for (const sim::Visual& visual : model.visuals) {
    for (const Eigen::Vector3f& vertex : scene.meshes[static_cast<std::size_t>(visual.mesh)].vertices)
      bounds.extend(model.world_from_model * visual.model_from_visual * vertex.cast<double>());
  }
  return bounds;
}

/// Copies a model with all it needs from one scene to another, standing at a pose.
void copyModel(const sim::Scene& from, const sim::Model& original, const Eigen::Isometry3d& pose,
               sim::Scene& to) {
  sim::Model model = original;
  model.world_from_model = pose;
  std::map<int, int> textures;
  std::map<int, int> materials;
  for (sim::Visual& visual : model.visuals) {
    sim::Mesh mesh = from.meshes[static_cast<std::size_t>(visual.mesh)];
    for (int& index : mesh.triangle_material) {
      if (index < 0) continue;
      if (materials.count(index) == 0) {
        sim::Material material = from.materials[static_cast<std::size_t>(index)];
        if (material.texture >= 0) {
          if (textures.count(material.texture) == 0) {
            textures[material.texture] = static_cast<int>(to.textures.size());
            to.textures.push_back(from.textures[static_cast<std::size_t>(material.texture)]);
          }
          material.texture = textures[material.texture];
        }
        materials[index] = static_cast<int>(to.materials.size());
        to.materials.push_back(material);
      }
      index = materials[index];
    }
    visual.mesh = static_cast<int>(to.meshes.size());
    to.meshes.push_back(std::move(mesh));
  }
  to.models.push_back(std::move(model));
}

class Builder {
 public:
  /// People look as appearances from `first_appearance` on say.
  Builder(const TrainingStock& stock, Random& random, std::uint64_t first_appearance)
      : stock_(stock), random_(random), first_appearance_(first_appearance) {}

  TrainingScene build(bool with_people) {
    constexpr double kShippedWorld = 0.2;
    if (random_.chance(kShippedWorld)) {
      takeWorld();
    } else {
      buildRoom();
    }
    const double area = place_.floor.volume();
    const int things = static_cast<int>(std::min(22.0, std::ceil(area * random_.uniform(0.08, 0.45))));
    for (int i = 0; i < things; ++i) addThing(i);
    const int people = !with_people || random_.chance(0.1) ? 0 : random_.integer(1, 4);
    for (int i = 0; i < people; ++i) addPerson(i);
    place_.people = sim::addPeople(place_.scene);
    for (const sim::PersonBody& body : place_.people)
      sim::posePerson(body, random_.uniform(0.0, 8.0), place_.scene);
    return std::move(place_);
  }

 private:
  sim::Scene& scene() { return place_.scene; }
  Paint paint() { return drawPaint(stock_.textures, random_, scene()); }

  Eigen::Vector2d drawPoint(double margin_m) {
    const Eigen::Vector2d low = place_.floor.min().array() + margin_m;
    const Eigen::Vector2d high = place_.floor.max().array() - margin_m;
    const double x = random_.uniform(low.x(), high.x());
    return {x, random_.uniform(low.y(), high.y())};
  }

  void takeWorld() {
    const int last = static_cast<int>(stock_.worlds.size()) - 1;
    place_.scene = stock_.worlds[static_cast<std::size_t>(random_.integer(0, last))];
    place_.scene.people.clear();
    for (const sim::Model& model : place_.scene.models) {
      if (model.name != "floor") continue;
      const Eigen::AlignedBox3d bounds = boundsOf(place_.scene, model);
      place_.floor = {bounds.min().head<2>(), bounds.max().head<2>()};
    }
    floor_paint_ = paint();
  }

  void buildRoom() {
    const double length = random_.uniform(3.5, 11.0);
    const double width = random_.chance(0.25) ? random_.uniform(1.6, 2.6) : random_.uniform(3.0, 8.0);
    height_m_ = random_.uniform(2.2, 3.4);
    place_.floor = {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(length, width)};
    const Eigen::Vector3d slab(length, width, 0.1);
    const Eigen::Vector2d middle = place_.floor.center();
    floor_paint_ = paint();
    sim::Mesh floor = sim::makeBox(slab);
    wear(floor_paint_, {length, width}, floor);
    add(std::move(floor), onFloor(middle, 0.0, -0.05), "floor", scene());
    addBox(slab, onFloor(middle, 0.0, height_m_ + 0.05), paint(), "ceiling", scene());
    const Paint walls = random_.chance(0.1) ? floor_paint_ : paint();
    const int window_wall = random_.integer(-2, 3);  // none for a negative number
    for (int side = 0; side < 4; ++side) addWall(side, walls, side == window_wall);
    addLights();
  }

  /// The pose of a wall's middle at the floor: x along it, y into the room.
  Eigen::Isometry3d wallPose(int side) const {
    const Eigen::Vector2d middle = place_.floor.center();
    const Eigen::Vector2d half = 0.5 * place_.floor.sizes();
    switch (side) {
      case 0:
        return onFloor({middle.x(), place_.floor.min().y()}, 0.0);
      case 1:
        return onFloor({place_.floor.max().x(), middle.y()}, M_PI_2);
      case 2:
        return onFloor({middle.x(), place_.floor.max().y()}, M_PI);
      default:
        return onFloor({middle.x() - half.x(), middle.y()}, -M_PI_2);
    }
  }

  void addWall(int side, const Paint& walls, bool with_window) {
    constexpr double kThickness_m = 0.1;
    const double length = side % 2 == 0 ? place_.floor.sizes().x() : place_.floor.sizes().y();
    const auto at = [&](double x, double z, double y) {
      return Eigen::Isometry3d(wallPose(side) * Eigen::Translation3d(x, y, z));
    };
    const auto part = [&](double from, double to, double low, double high) {
      addBox({to - from, kThickness_m, high - low},
             at(0.5 * (from + to), 0.5 * (low + high), -0.5 * kThickness_m), walls, "wall", scene());
    };
    const double half = 0.5 * length + kThickness_m;
    if (with_window) {
      const double sill = random_.uniform(0.3, 1.2);
      const double top = random_.uniform(sill + 0.6, height_m_);
      const double wide = random_.uniform(0.15, 0.45) * length;
      part(-half, half, 0.0, sill);
      part(-half, half, top, height_m_);
      part(-half, -wide, sill, top);
      part(wide, half, sill, top);
    } else {
      part(-half, half, 0.0, height_m_);
    }
    if (random_.chance(0.5))  // a skirting board
      addBox({length, 0.016, random_.uniform(0.04, 0.12)}, at(0.0, 0.03, 0.008), paint(), "skirting",
             scene());
    const int pictures = with_window ? 0 : random_.integer(0, 2);
    for (int i = 0; i < pictures; ++i) {
      const bool door = random_.chance(0.3);
      const Eigen::Vector3d size(random_.uniform(0.3, door ? 1.0 : 1.4), 0.03,
                                 door ? 2.0 : random_.uniform(0.3, 1.0));
      const double x = random_.uniform(-0.4, 0.4) * length;
      Paint front = paint();
      front.repeat_m = std::max(size.x(), size.z());
      addBox(size, at(x, door ? 1.0 : random_.uniform(1.0, 1.8), 0.015), front, "picture", scene());
    }
  }

  void addLights() {
    sim::Light sun;
    sun.kind = sim::Light::Kind::kDirectional;
    const double azimuth = random_.uniform(-M_PI, M_PI);
    sun.direction =
        Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), -random_.uniform(0.3, 1.5)).normalized();
    sun.casts_shadows = random_.chance(0.6);
    scene().lights.push_back(sun);
    const int lamps = random_.integer(1, 3);
    for (int i = 0; i < lamps; ++i) {
      sim::Light lamp;
      lamp.position_m << drawPoint(0.4), height_m_ - random_.uniform(0.1, 0.5);
      lamp.color = Eigen::Vector3f(1.0F, static_cast<float>(random_.uniform(0.8, 1.0)),
                                   static_cast<float>(random_.uniform(0.55, 1.0)));
      lamp.color *= static_cast<float>(random_.uniform(0.4, 1.0));
      lamp.attenuation_constant = 0.3;
      lamp.attenuation_linear = 0.1;
      lamp.attenuation_quadratic = random_.uniform(0.02, 0.2);
      scene().lights.push_back(lamp);
    }
    for (int c = 0; c < 3; ++c) scene().ambient[c] = static_cast<float>(random_.uniform(0.12, 0.45));
  }

  void addThing(int number) {
    const Eigen::Vector2d p = drawPoint(0.2);
    const double yaw = random_.uniform(-M_PI, M_PI);
    const std::string name = "thing_" + std::to_string(number);
    place_.objects.push_back(p);
    const double kind = random_.uniform(0.0, 1.0);
    if (kind < 0.3) {
      addFurniture(Pose2{p.x(), p.y(), yaw}, name);
    } else if (kind < 0.5 && !stock_.furniture.empty()) {
      const auto [world, model] = stock_.furniture[static_cast<std::size_t>(
          random_.integer(0, static_cast<int>(stock_.furniture.size()) - 1))];
      const sim::Scene& from = stock_.worlds[world];
      copyModel(from, from.models[model], onFloor(p, yaw), scene());
    } else {
      addPile(p, yaw, name);
    }
  }

  Paint thingPaint() { return random_.chance(0.12) ? floor_paint_ : paint(); }

  void addFurniture(const Pose2& pose, const std::string& name) {
    using Maker = Furniture (*)(Random&);
    constexpr Maker kMakers[] = {makeTable,  makeChair, makeCabinet, makeShelf,
                                 makeCarton, makeBin,   makePillar};
    std::vector<Solid> solids;
    const std::size_t first_mesh = scene().meshes.size();
    place(kMakers[static_cast<std::size_t>(random_.integer(0, 6))](random_), pose, name, scene(), solids);
    const Paint look = thingPaint();
    for (std::size_t m = first_mesh; m < scene().meshes.size(); ++m)
      wear(look, {0.6, 0.6}, scene().meshes[m]);
  }

  /// One to three shapes on top of each other.
  void addPile(const Eigen::Vector2d& p, double yaw, const std::string& name) {
    double floor_m = random_.chance(0.06) ? random_.uniform(0.4, 1.4) : 0.0;  // some hang
    const int count = random_.chance(0.65) ? 1 : random_.integer(2, 3);
    for (int i = 0; i < count; ++i) {
      const double tall = random_.chance(0.15) ? random_.uniform(0.03, 0.12)
                                               : std::exp(random_.uniform(std::log(0.15), std::log(1.9)));
      const double wide = std::exp(random_.uniform(std::log(0.06), std::log(1.1)));
      const Eigen::Isometry3d pose = onFloor(p, yaw, floor_m + 0.5 * tall);
      const Paint look = thingPaint();
      const double shape = random_.uniform(0.0, 1.0);
      if (shape < 0.55) {
        addBox({wide, wide * random_.uniform(0.1, 1.5), tall}, pose, look, name, scene());
      } else {
        const bool round = shape > 0.85;
        const double radius = 0.5 * (round ? std::min(wide, 0.9) : wide);
        sim::Mesh mesh = round ? sim::makeSphere(radius) : sim::makeCylinder(radius, tall);
        wear(look, {M_PI * wide, round ? wide : tall}, mesh);
        add(std::move(mesh), round ? onFloor(p, yaw, floor_m + radius) : pose, name, scene());
        if (round) break;
      }
      floor_m += tall;
    }
  }

  void addPerson(int number) {
    sim::Person person;
    person.name = "person_" + std::to_string(number);
    person.appearance = first_appearance_ + static_cast<std::uint64_t>(random_.integer(0, last_appearance_));
    const Eigen::Vector2d p = drawPoint(0.35);
    const Pose2 pose{p.x(), p.y(), random_.uniform(-M_PI, M_PI)};
    person.waypoints.push_back({0.0, pose});
    const double posture = random_.uniform(0.0, 1.0);
    if (posture < 0.3) {
      person.posture = sim::Posture::kWalking;
      const double distance_m = random_.uniform(0.1, 0.5);  // stays near: legs need a distance, not a way
      person.waypoints.push_back({10.0, pose * Pose2{distance_m, 0.0, 0.0}});
      person.loop = false;
    } else if (posture < 0.55) {
      person.posture = sim::Posture::kSitting;
      std::vector<Solid> solids;
      if (random_.chance(0.8)) place(makeChair(random_), pose, "seat", scene(), solids);
    }
    scene().people.push_back(person);
  }

  const TrainingStock& stock_;
  Random& random_;
  std::uint64_t first_appearance_;
  int last_appearance_ = first_appearance_ < kFirstTrainingSeed ? 999999 : 1 << 30;
  TrainingScene place_;
  Paint floor_paint_;
  double height_m_ = 2.6;
};

/// Whether a model of a world is a piece that can stand elsewhere: small, and on the floor.
bool isPiece(const sim::Scene& scene, const sim::Model& model) {
  const Eigen::AlignedBox3d bounds = boundsOf(scene, model);
  return !bounds.isEmpty() && bounds.sizes().maxCoeff() < 2.3 && std::abs(bounds.min().z()) < 0.05;
}

}  // namespace

TrainingStock readTrainingStock(const std::string& worlds_folder) {
  TrainingStock stock;
  stock.textures = readTextures(worlds_folder + "/textures");
  for (const char* name : {"lab", "corridor"}) {
    stock.worlds.push_back(sim::loadWorld(worlds_folder + "/" + name + ".world", {}).scene);
    const sim::Scene& scene = stock.worlds.back();
    for (std::size_t m = 0; m < scene.models.size(); ++m) {
      if (isPiece(scene, scene.models[m])) stock.furniture.emplace_back(stock.worlds.size() - 1, m);
    }
  }
  return stock;
}

TrainingScene makeTrainingScene(std::uint64_t seed, const TrainingStock& stock) {
  if (seed < kFirstTrainingSeed) {
    throw ConfigError("training scenes have seeds from " + std::to_string(kFirstTrainingSeed) + ", not " +
                      std::to_string(seed) +
                      ": evaluation and tuning own the lower ones, and no network may learn what it is "
                      "measured on");
  }
  Random random(seed, "training scene");
  return Builder(stock, random, kFirstTrainingSeed).build(true);
}

TrainingScene makeUnseenScene(std::uint64_t seed, const TrainingStock& stock, bool with_people) {
  if (seed >= kFirstTrainingSeed) {
    throw ConfigError("seed " + std::to_string(seed) +
                      " is a training scene's: evaluation draws below 100000, " +
                      "tuning from 500000 to 999999");
  }
  Random random(seed, "unseen scene");
  return Builder(stock, random, 0).build(with_people);
}

}  // namespace frugal_nav::eval
