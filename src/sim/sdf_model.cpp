#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include <sdf/Box.hh>
#include <sdf/Collision.hh>
#include <sdf/Cylinder.hh>
#include <sdf/Element.hh>
#include <sdf/Geometry.hh>
#include <sdf/Link.hh>
#include <sdf/Mesh.hh>
#include <sdf/Plane.hh>
#include <sdf/Sphere.hh>
#include <sdf/Visual.hh>
#include <sdf/sdf_config.h>

#include <frugal_nav/sim/primitive_mesh.hpp>
#include <frugal_nav/sim/sdf_model.hpp>

namespace frugal_nav::sim {
namespace {

Eigen::Vector3d toVector(const ignition::math::Vector3d& v) { return {v.X(), v.Y(), v.Z()}; }

/// A key that is equal for equal shapes only.
template <class... Numbers>
std::string shapeKey(const char* kind, Numbers... numbers) {
  std::ostringstream key;
  key << kind << std::hexfloat;
  ((key << ' ' << numbers), ...);
  return key.str();
}

std::optional<int> addMeshShape(const sdf::Mesh& mesh, const std::optional<Surface>& surface,
                                const std::string& owner, SceneBuilder& builder) {
  const std::string folder = std::filesystem::path(mesh.FilePath()).parent_path().string();
  return builder.addMeshFile(mesh.Uri(), folder, {mesh.Submesh(), mesh.CenterSubmesh()},
                             toVector(mesh.Scale()), surface, owner);
}

/// The mesh that draws a geometry; nothing for what is not simulated.
std::optional<int> addShape(const sdf::Geometry& geometry, const std::optional<Surface>& surface,
                            const std::string& owner, SceneBuilder& builder) {
  const Material material = surface ? surface->material : Material{};
  if (const auto* box = geometry.BoxShape()) {
    const Eigen::Vector3d size = toVector(box->Size());
    return builder.addPrimitive(
        shapeKey("box", size.x(), size.y(), size.z()), [&] { return makeBox(size); }, material);
  }
  if (const auto* cylinder = geometry.CylinderShape()) {
    const double radius = cylinder->Radius();
    const double length = cylinder->Length();
    return builder.addPrimitive(
        shapeKey("cylinder", radius, length), [&] { return makeCylinder(radius, length); }, material);
  }
  if (const auto* sphere = geometry.SphereShape()) {
    const double radius = sphere->Radius();
    return builder.addPrimitive(
        shapeKey("sphere", radius), [&] { return makeSphere(radius); }, material);
  }
  if (const auto* plane = geometry.PlaneShape()) {
    const Eigen::Vector2d size(plane->Size().X(), plane->Size().Y());
    const Eigen::Vector3d normal = toVector(plane->Normal());
    return builder.addPrimitive(
        shapeKey("plane", size.x(), size.y(), normal.x(), normal.y(), normal.z()),
        [&] { return makePlane(size, normal); }, material);
  }
  if (const auto* mesh = geometry.MeshShape()) return addMeshShape(*mesh, surface, owner, builder);
  return std::nullopt;
}

/// The solid shape of a geometry; nothing for what is not simulated.
std::optional<Collision> toCollision(const sdf::Geometry& geometry, const std::string& owner,
                                     SceneBuilder& builder) {
  Collision collision;
  if (const auto* box = geometry.BoxShape()) {
    collision.kind = Collision::Kind::kBox;
    collision.size_m = toVector(box->Size());
  } else if (const auto* cylinder = geometry.CylinderShape()) {
    collision.kind = Collision::Kind::kCylinder;
    collision.size_m = {cylinder->Radius(), cylinder->Radius(), cylinder->Length()};
  } else if (const auto* sphere = geometry.SphereShape()) {
    collision.kind = Collision::Kind::kSphere;
    collision.size_m = Eigen::Vector3d::Constant(sphere->Radius());
  } else if (const auto* plane = geometry.PlaneShape()) {
    collision.kind = Collision::Kind::kPlane;
    collision.size_m = toVector(plane->Normal()).normalized();
  } else if (const auto* mesh_shape = geometry.MeshShape()) {
    const auto mesh = addMeshShape(*mesh_shape, std::nullopt, owner, builder);
    if (!mesh) return std::nullopt;
    collision.kind = Collision::Kind::kMesh;
    collision.mesh = *mesh;
  } else {
    return std::nullopt;
  }
  return collision;
}

void addVisual(const sdf::Visual& source, const Eigen::Isometry3d& model_from_link, const std::string& owner,
               SceneBuilder& builder, Model& model) {
  if (source.Geom() == nullptr) return;
  constexpr float kOpaque = 0.01F;
  if (source.Transparency() >= 1.0F - kOpaque) return;  // invisible on purpose
  if (source.Transparency() > kOpaque) builder.warn("transparency of " + owner + " is not simulated");
  std::optional<Surface> surface;
  if (source.Material() != nullptr) surface = readSurface(*source.Material(), owner, builder);
  const auto mesh = addShape(*source.Geom(), surface, owner, builder);
  if (!mesh) return;
  Visual visual;
  visual.mesh = *mesh;
  visual.model_from_visual = model_from_link * resolvePose(source.SemanticPose(), owner, builder);
  model.visuals.push_back(visual);
}

void addCollision(const sdf::Collision& source, const Eigen::Isometry3d& model_from_link,
                  const std::string& owner, SceneBuilder& builder, Model& model) {
  if (source.Geom() == nullptr) return;
  auto collision = toCollision(*source.Geom(), owner, builder);
  if (!collision) return;
  collision->model_from_collision = model_from_link * resolvePose(source.SemanticPose(), owner, builder);
  model.collisions.push_back(*collision);
}

/// Adds a model's links and nested models to the scene's model; `model_from_part` is where the part stands in
/// it.
void addParts(const sdf::Model& part, const Eigen::Isometry3d& model_from_part, const std::string& owner,
              SceneBuilder& builder, Model& model) {
  for (std::uint64_t i = 0; i < part.LinkCount(); ++i) {
    const sdf::Link& link = *part.LinkByIndex(i);
    const Eigen::Isometry3d model_from_link =
        model_from_part * resolvePose(link.SemanticPose(), owner, builder);
    for (std::uint64_t k = 0; k < link.VisualCount(); ++k) {
      addVisual(*link.VisualByIndex(k), model_from_link, owner, builder, model);
    }
    for (std::uint64_t k = 0; k < link.CollisionCount(); ++k) {
      addCollision(*link.CollisionByIndex(k), model_from_link, owner, builder, model);
    }
    for (std::uint64_t k = 0; k < link.LightCount(); ++k) {
      addLight(*link.LightByIndex(k), model.world_from_model * model_from_link, builder);
    }
  }
#if SDF_MAJOR_VERSION >= 10  // before, the parser itself merges nested models
  for (std::uint64_t i = 0; i < part.ModelCount(); ++i) {
    const sdf::Model& child = *part.ModelByIndex(i);
    addParts(child, model_from_part * resolvePose(child.SemanticPose(), owner, builder),
             owner + "::" + child.Name(), builder, model);
  }
#endif
}

/// FNV-1a of a name: the same person looks the same in every run and on every machine.
std::uint64_t hashName(const std::string& name) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return hash;
}

Posture postureFromSkin(const std::string& skin_uri) {
  std::string name = std::filesystem::path(skin_uri).filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name.find("sit") != std::string::npos) return Posture::kSitting;
  if (name.find("stand") != std::string::npos) return Posture::kStanding;
  return Posture::kWalking;
}

Pose2 toPose2(const ignition::math::Pose3d& pose) {
  return {pose.Pos().X(), pose.Pos().Y(), wrapAngle(pose.Rot().Yaw())};
}

}  // namespace

Eigen::Isometry3d toIsometry(const ignition::math::Pose3d& pose) {
  Eigen::Isometry3d isometry = Eigen::Isometry3d::Identity();
  isometry.linear() =
      Eigen::Quaterniond(pose.Rot().W(), pose.Rot().X(), pose.Rot().Y(), pose.Rot().Z()).toRotationMatrix();
  isometry.translation() = toVector(pose.Pos());
  return isometry;
}

Eigen::Isometry3d resolvePose(const sdf::SemanticPose& pose, const std::string& owner,
                              SceneBuilder& builder) {
  ignition::math::Pose3d resolved;
  if (pose.Resolve(resolved).empty()) return toIsometry(resolved);
  builder.warn("a pose of " + owner + " is relative to " +
               (pose.RelativeTo().empty() ? "a frame that does not exist" : pose.RelativeTo()) +
               ", which cannot be resolved: taken as relative to its parent");
  return toIsometry(pose.RawPose());
}

void addModel(const sdf::Model& source, const Eigen::Isometry3d& world_from_model, SceneBuilder& builder) {
  Model model;
  model.name = source.Name();
  model.world_from_model = world_from_model;
  addParts(source, Eigen::Isometry3d::Identity(), source.Name(), builder, model);
  if (!model.visuals.empty() || !model.collisions.empty()) builder.scene.models.push_back(std::move(model));
}

void addLight(const sdf::Light& source, const Eigen::Isometry3d& world_from_parent, SceneBuilder& builder) {
  const Eigen::Isometry3d world_from_light =
      world_from_parent * resolvePose(source.SemanticPose(), source.Name(), builder);
  Light light;
  light.name = source.Name();
  switch (source.Type()) {
    case sdf::LightType::DIRECTIONAL:
      light.kind = Light::Kind::kDirectional;
      break;
    case sdf::LightType::SPOT:
      light.kind = Light::Kind::kSpot;
      break;
    default:
      light.kind = Light::Kind::kPoint;
      break;
  }
  light.color = {source.Diffuse().R(), source.Diffuse().G(), source.Diffuse().B()};
  if (source.Element() && source.Element()->HasElement("intensity")) {
    light.color *= static_cast<float>(source.Element()->Get<double>("intensity"));
  }
  light.position_m = world_from_light.translation();
  const Eigen::Vector3d direction = toVector(source.Direction());
  if (direction.norm() > 0.0) light.direction = world_from_light.linear() * direction.normalized();
  light.range_m = source.AttenuationRange();
  light.attenuation_constant = source.ConstantAttenuationFactor();
  light.attenuation_linear = source.LinearAttenuationFactor();
  light.attenuation_quadratic = source.QuadraticAttenuationFactor();
  light.spot_inner_rad = source.SpotInnerAngle().Radian();
  light.spot_outer_rad = source.SpotOuterAngle().Radian();
  light.casts_shadows = source.CastShadows();
  builder.scene.lights.push_back(light);
}

void addActor(const sdf::Actor& actor, SceneBuilder& builder) {
  Person person;
  person.name = actor.Name();
  person.posture = postureFromSkin(actor.SkinFilename());
  person.appearance = hashName(actor.Name());
  person.start_delay_s = actor.ScriptDelayStart();
  person.loop = actor.ScriptLoop();
  // Several trajectories follow one another; each counts its time from zero.
  double start_s = 0.0;
  for (std::uint64_t i = 0; i < actor.TrajectoryCount(); ++i) {
    const sdf::Trajectory& trajectory = *actor.TrajectoryByIndex(i);
    double end_s = start_s;
    for (std::uint64_t k = 0; k < trajectory.WaypointCount(); ++k) {
      const sdf::Waypoint& waypoint = *trajectory.WaypointByIndex(k);
      person.waypoints.push_back({start_s + waypoint.Time(), toPose2(waypoint.Pose())});
      end_s = std::max(end_s, start_s + waypoint.Time());
    }
    start_s = end_s;
  }
  std::stable_sort(person.waypoints.begin(), person.waypoints.end(),
                   [](const Waypoint& a, const Waypoint& b) { return a.time_s < b.time_s; });
  if (person.waypoints.empty()) person.waypoints.push_back({0.0, toPose2(actor.RawPose())});
  builder.scene.people.push_back(std::move(person));
}

}  // namespace frugal_nav::sim
