#include "furniture.hpp"

#include <utility>

#include <frugal_nav/sim/primitive_mesh.hpp>

namespace frugal_nav::eval {
namespace {

Part box(const Eigen::Vector2d& centre, const Eigen::Vector2d& size_m, double bottom_m, double height_m) {
  Part part;
  part.outline.world_from_solid = {centre.x(), centre.y(), 0.0};
  part.outline.size_m = size_m;
  part.outline.overhang = bottom_m >= kRobotHeight_m;
  part.bottom_m = bottom_m;
  part.height_m = height_m;
  return part;
}

Part cylinder(double radius_m, double height_m) {
  Part part;
  part.outline.radius_m = radius_m;
  part.height_m = height_m;
  return part;
}

/// Four legs at the corners of a rectangle.
std::vector<Part> legs(const Eigen::Vector2d& size_m, double thickness_m, double height_m) {
  const Eigen::Vector2d out = 0.5 * (size_m - Eigen::Vector2d::Constant(thickness_m));
  std::vector<Part> parts;
  for (const double x : {-out.x(), out.x()}) {
    for (const double y : {-out.y(), out.y()})
      parts.push_back(box({x, y}, Eigen::Vector2d::Constant(thickness_m), 0.0, height_m));
  }
  return parts;
}

Furniture solidBox(std::string kind, const Eigen::Vector2d& size_m, double height_m,
                   const Eigen::Vector3f& colour) {
  return {std::move(kind), {box({0.0, 0.0}, size_m, 0.0, height_m)}, size_m, colour};
}

Furniture solidCylinder(std::string kind, double radius_m, double height_m, const Eigen::Vector3f& colour) {
  return {std::move(kind), {cylinder(radius_m, height_m)}, Eigen::Vector2d::Constant(2.0 * radius_m), colour};
}

}  // namespace

Furniture makeWall(double length_m) { return solidBox("wall", {length_m, 0.1}, 1.5, {0.8F, 0.8F, 0.76F}); }

Furniture makeTable(Random& random) {
  const double length = random.uniform(1.0, 1.6);
  const double depth = random.uniform(0.6, 0.8);
  Furniture table{"table", legs({length, depth}, 0.05, 0.70), {length, depth}, {0.7F, 0.5F, 0.3F}};
  table.parts.push_back(box({0.0, 0.0}, {length, depth}, 0.70, 0.03));
  return table;
}

Furniture makeChair(Random& random) {
  const double side = random.uniform(0.38, 0.46);
  Furniture chair{"chair", legs({side, side}, 0.035, 0.44), {side, side}, {0.3F, 0.3F, 0.5F}};
  chair.parts.push_back(box({0.0, 0.0}, {side, side}, 0.44, 0.03));
  chair.parts.push_back(box({-0.5 * side + 0.02, 0.0}, {0.04, side}, 0.47, 0.40));
  return chair;
}

Furniture makeCabinet(Random& random) {
  const double length = random.uniform(0.4, 1.0);
  const double depth = random.uniform(0.35, 0.5);
  return solidBox("cabinet", {length, depth}, random.uniform(0.8, 1.8), {0.6F, 0.6F, 0.65F});
}

Furniture makeShelf(Random& random) {
  const double length = random.uniform(0.8, 1.2);
  const double depth = random.uniform(0.28, 0.35);
  Furniture shelf = solidBox("shelf", {length, depth}, 0.25, {0.55F, 0.4F, 0.25F});  // the plinth
  for (const double x : {-0.5 * length + 0.01, 0.5 * length - 0.01})
    shelf.parts.push_back(box({x, 0.0}, {0.02, depth}, 0.25, 1.4));
  for (const double z : {0.6, 0.95, 1.3, 1.63})
    shelf.parts.push_back(box({0.0, 0.0}, {length, depth}, z, 0.02));
  return shelf;
}

Furniture makeCarton(Random& random) {
  const double length = random.uniform(0.3, 0.6);
  const double depth = random.uniform(0.3, 0.6);
  return solidBox("carton", {length, depth}, random.uniform(0.3, 0.6), {0.7F, 0.55F, 0.35F});
}

Furniture makeBin(Random& random) {
  const double radius = random.uniform(0.12, 0.25);
  return solidCylinder("bin", radius, random.uniform(0.4, 0.8), {0.2F, 0.4F, 0.3F});
}

Furniture makePillar(Random& random) {
  return solidCylinder("pillar", random.uniform(0.05, 0.15), 1.5, {0.75F, 0.75F, 0.75F});
}

void place(const Furniture& piece, const Pose2& world_from_piece, const std::string& name, sim::Scene& scene,
           std::vector<Solid>& solids) {
  sim::Material material;
  material.name = name;
  material.albedo = piece.colour;
  const int material_index = static_cast<int>(scene.materials.size());
  scene.materials.push_back(material);

  sim::Model model;
  model.name = name;
  model.world_from_model.translate(Eigen::Vector3d(world_from_piece.x_m, world_from_piece.y_m, 0.0));
  model.world_from_model.rotate(Eigen::AngleAxisd(world_from_piece.yaw_rad, Eigen::Vector3d::UnitZ()));
  for (const Part& part : piece.parts) {
    const Solid& outline = part.outline;
    const bool round = outline.radius_m > 0.0;
    const Eigen::Vector3d box_size(outline.size_m.x(), outline.size_m.y(), part.height_m);
    const Eigen::Vector3d round_size(outline.radius_m, outline.radius_m, part.height_m);
    sim::Mesh mesh = round ? sim::makeCylinder(outline.radius_m, part.height_m) : sim::makeBox(box_size);
    mesh.triangle_material.assign(mesh.triangles.size(), material_index);

    Eigen::Isometry3d model_from_part = Eigen::Isometry3d::Identity();
    model_from_part.translate(Eigen::Vector3d(outline.world_from_solid.x_m, outline.world_from_solid.y_m,
                                              part.bottom_m + 0.5 * part.height_m));
    model.visuals.push_back({static_cast<int>(scene.meshes.size()), model_from_part});
    scene.meshes.push_back(std::move(mesh));
    model.collisions.push_back({round ? sim::Collision::Kind::kCylinder : sim::Collision::Kind::kBox,
                                round ? round_size : box_size, -1, model_from_part});

    Solid solid = outline;
    solid.world_from_solid = world_from_piece * outline.world_from_solid;
    solids.push_back(solid);
  }
  scene.models.push_back(std::move(model));
}

}  // namespace frugal_nav::eval
