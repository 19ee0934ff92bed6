#include "camera_room.hpp"

#include <algorithm>
#include <cmath>

#include <frugal_nav/sim/primitive_mesh.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kWall_m = 0.1;
constexpr double kDoorHalf_m = 0.5;
constexpr double kDoorHeight_m = 2.05;
constexpr double kCloset_m = 1.0;

Part boxPart(const Eigen::Vector2d& size_m, double bottom_m, double height_m) {
  Part part;
  part.outline.size_m = size_m;
  part.outline.overhang = bottom_m >= kRobotHeight_m;
  part.bottom_m = bottom_m;
  part.height_m = height_m;
  return part;
}

Furniture single(const std::string& kind, const Part& part) {
  return {kind, {part}, part.outline.size_m, {0.6F, 0.6F, 0.6F}};
}

}  // namespace

void CameraRoom::put(const Furniture& piece, const Pose2& pose, const std::string& name, const Paint& look,
                     const Eigen::Vector2d& face_m) {
  const std::size_t first_mesh = scene_.meshes.size();
  place(piece, pose, name + "_" + std::to_string(number_++), scene_, solids);
  for (std::size_t m = first_mesh; m < scene_.meshes.size(); ++m) wear(look, face_m, scene_.meshes[m]);
}

void CameraRoom::addSlab(const Eigen::AlignedBox2d& area, double bottom_m, double thickness_m,
                         const Paint& look, const std::string& name) {
  const Eigen::Vector2d size = area.sizes();
  sim::Mesh mesh = sim::makeBox({size.x(), size.y(), thickness_m});
  wear(look, size, mesh);
  sim::Model model;
  model.name = name;
  model.world_from_model.translation() << area.center(), bottom_m + 0.5 * thickness_m;
  model.visuals.push_back({static_cast<int>(scene_.meshes.size()), Eigen::Isometry3d::Identity()});
  scene_.meshes.push_back(std::move(mesh));
  scene_.models.push_back(std::move(model));
}

void CameraRoom::addWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Span heights) {
  const double length = (to - from).norm();
  const double height = heights.to_m - heights.from_m;
  if (length < 0.01 || height < 0.01) return;
  const Eigen::Vector2d middle = 0.5 * (from + to);
  const Pose2 pose{middle.x(), middle.y(), std::atan2(to.y() - from.y(), to.x() - from.x())};
  put(single("wall", boxPart({length, kWall_m}, heights.from_m, height)), pose, "wall", walls_,
      {length, height});
}

void CameraRoom::addCloset(double x_m, double y_m, double outward) {
  const double back = y_m + outward * (kWall_m + kCloset_m);
  for (const double side : {-1.0, 1.0}) {
    const double x = x_m + side * (kDoorHalf_m + 0.5 * kWall_m + 0.02);
    addWall({x, y_m}, {x, back}, {0.0, height_m_});
  }
  addWall({x_m - 0.7, back}, {x_m + 0.7, back}, {0.0, height_m_});
}

void CameraRoom::addSideWall(double y_m, double outward, std::optional<double> door_x_m) {
  const double y = y_m + outward * 0.5 * kWall_m;
  const double from = floor_.min().x() - kWall_m;
  const double to = floor_.max().x() + kWall_m;
  if (!door_x_m) {
    addWall({from, y}, {to, y}, {0.0, height_m_});
    return;
  }
  addWall({from, y}, {*door_x_m - kDoorHalf_m, y}, {0.0, height_m_});
  addWall({*door_x_m + kDoorHalf_m, y}, {to, y}, {0.0, height_m_});
  addWall({*door_x_m - kDoorHalf_m, y}, {*door_x_m + kDoorHalf_m, y}, {kDoorHeight_m, height_m_});
  addCloset(*door_x_m, y_m, outward);
}

void CameraRoom::addEndWall(double x_m, double outward) {
  const double x = x_m + outward * 0.5 * kWall_m;
  const double from = floor_.min().y() - kWall_m;
  const double to = floor_.max().y() + kWall_m;
  if (!random_.chance(0.4)) {
    addWall({x, from}, {x, to}, {0.0, height_m_});
    return;
  }
  // With a window, through which the sky is seen and the sun shines.
  const double sill = random_.uniform(0.8, 1.2);
  const double top = random_.uniform(sill + 0.7, height_m_ - 0.1);
  const double middle = 0.5 * (from + to);
  const double half = 0.5 * random_.uniform(0.4, 0.7) * (to - from);
  addWall({x, from}, {x, to}, {0.0, sill});
  addWall({x, from}, {x, to}, {top, height_m_});
  addWall({x, from}, {x, middle - half}, {sill, top});
  addWall({x, middle + half}, {x, to}, {sill, top});
}

void CameraRoom::addPictures(double y_m, double inward, std::optional<double> door_x_m) {
  const int pictures = random_.integer(1, 4);
  for (int i = 0; i < pictures; ++i) {
    const double wide = random_.uniform(0.3, 1.2);
    const double tall = random_.uniform(0.3, 0.9);
    const double x = random_.uniform(floor_.min().x() + wide, floor_.max().x() - wide);
    const double z = random_.uniform(1.0, 1.7) - 0.5 * tall;
    if (door_x_m && std::abs(x - *door_x_m) < kDoorHalf_m + 0.5 * wide) continue;
    Paint front = paint();
    front.repeat_m = std::max(wide, tall);
    put(single("picture", boxPart({wide, 0.02}, z, tall)), {x, y_m + inward * 0.011, 0.0}, "picture", front,
        {wide, tall});
  }
}

void CameraRoom::addLamps() {
  sim::Light sun;
  sun.kind = sim::Light::Kind::kDirectional;
  const double azimuth = random_.uniform(-M_PI, M_PI);
  sun.direction =
      Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), -random_.uniform(0.4, 1.5)).normalized();
  scene_.lights.push_back(sun);
  const int lamps = floor_.sizes().x() > 7.0 ? 3 : 2;
  for (int i = 0; i < lamps; ++i) {
    sim::Light lamp;
    const double x = floor_.min().x() + (i + random_.uniform(0.3, 0.7)) / lamps * floor_.sizes().x();
    const double y = floor_.center().y() + random_.uniform(-0.2, 0.2) * floor_.sizes().y();
    lamp.position_m = {x, y, height_m_ - random_.uniform(0.1, 0.4)};
    lamp.color = Eigen::Vector3f(1.0F, static_cast<float>(random_.uniform(0.85, 1.0)),
                                 static_cast<float>(random_.uniform(0.65, 1.0)));
    lamp.color *= static_cast<float>(random_.uniform(0.5, 1.0));
    lamp.attenuation_constant = 0.3;
    lamp.attenuation_linear = 0.1;
    lamp.attenuation_quadratic = random_.uniform(0.02, 0.2);
    scene_.lights.push_back(lamp);
  }
  for (int c = 0; c < 3; ++c) scene_.ambient[c] = static_cast<float>(random_.uniform(0.15, 0.4));
}

void CameraRoom::build(const Eigen::AlignedBox2d& floor, std::optional<double> door_x_m) {
  floor_ = floor;
  door_x_m_ = door_x_m;
  height_m_ = random_.uniform(2.4, 3.0);
  scene_.name = "camera layout";
  const Eigen::Vector2d around = Eigen::Vector2d::Constant(kCloset_m + 0.3);
  const Eigen::AlignedBox2d whole(Eigen::Vector2d(floor.min() - around),
                                  Eigen::Vector2d(floor.max() + around));
  addSlab(whole, -0.1, 0.1, paint(), "floor");
  addSlab(whole, height_m_, 0.1, paint(), "ceiling");
  walls_ = paint();
  for (const double side : {-1.0, 1.0}) {
    const double y = side < 0.0 ? floor.min().y() : floor.max().y();
    addSideWall(y, side, door_x_m);
    addPictures(y, -side, door_x_m);
    addEndWall(side < 0.0 ? floor.min().x() : floor.max().x(), side);
  }
  addLamps();
}

void CameraRoom::closeRow(double x_m, double from_y_m, double to_y_m) {
  const double length = to_y_m - from_y_m;
  constexpr double kShortest_m = 0.03;
  if (length < kShortest_m) return;
  const double depth = random_.uniform(0.1, 0.4);
  const double tall = random_.chance(0.5) ? height_m_ : random_.uniform(0.8, 1.8);
  const Paint look = tall == height_m_ ? walls_ : paint();
  put(single("partition", boxPart({depth, length}, 0.0, tall)), {x_m, 0.5 * (from_y_m + to_y_m), 0.0},
      "partition", look, {length, tall});
}

void CameraRoom::addPillar(const Eigen::Vector2d& p, double width_m) {
  put(single("pillar", boxPart({width_m, width_m}, 0.0, height_m_)), {p.x(), p.y(), 0.0}, "pillar", walls_,
      {width_m, height_m_});
}

Furniture CameraRoom::drawFurniture() {
  switch (random_.integer(0, 4)) {
    case 0:
      return makeTable(random_);
    case 1:
      return makeChair(random_);
    case 2:
      return makeShelf(random_);
    case 3:
      return makeCarton(random_);
    default:
      return makeCabinet(random_);
  }
}

void CameraRoom::furnish(double right_m, double left_m, double lane_end_m, double row_x_m) {
  const int pieces = random_.integer(3, 8);
  for (int i = 0; i < pieces; ++i) {
    const Furniture piece = drawFurniture();
    const double half = 0.5 * piece.size_m.x();
    const bool left = random_.chance(0.5);
    const double x = random_.uniform(floor_.min().x() + half, floor_.max().x() - half);
    constexpr double kAtWall_m = 0.02;
    const double depth = piece.size_m.y() + kAtWall_m;
    const double y = left ? floor_.max().y() - 0.5 * depth : floor_.min().y() + 0.5 * depth;
    const bool in_lane = left ? floor_.max().y() - depth < left_m : floor_.min().y() + depth > right_m;
    constexpr double kBehindStart_m = -0.6;
    const bool beside_lane = x + half > kBehindStart_m && x - half < lane_end_m;
    if (in_lane && beside_lane) continue;
    if (door_x_m_ && std::abs(x - *door_x_m_) < half + kDoorHalf_m + 0.1) continue;
    if (std::abs(x - row_x_m) < half + 0.5) continue;
    const Solid outline{{x, y, 0.0}, piece.size_m, 0.0, false};
    const bool clear = std::none_of(solids.begin(), solids.end(), [&](const Solid& solid) {
      const Polygon2 corners = outline.outline();
      return !solid.overhang &&
             (outline.distanceTo(solid.world_from_solid.position()) < 0.02 ||
              std::any_of(corners.begin(), corners.end(),
                          [&](const Eigen::Vector2d& corner) { return solid.distanceTo(corner) < 0.01; }));
    });
    if (clear) put(piece, {x, y, left ? M_PI : 0.0}, piece.kind, paint(), {0.6, 0.6});
  }
}

void CameraRoom::addObstacle(const Eigen::Vector2d& p, double width_m, double height_m) {
  const double shape = random_.uniform(0.0, 1.0);
  const Paint look = paint();
  constexpr double kWidestBin_m = 0.6;
  if (shape < 0.25 && width_m < kWidestBin_m) {
    Part part = boxPart({0.0, 0.0}, 0.0, height_m);
    part.outline.radius_m = 0.5 * width_m;
    put({"bin", {part}, {width_m, width_m}, {0.5F, 0.5F, 0.5F}}, {p.x(), p.y(), 0.0}, "bin", look,
        {M_PI * width_m, height_m});
    return;
  }
  // A box turned a little, its outline as wide as asked for.
  const double depth = random_.uniform(0.15, std::min(0.45, 0.1 + width_m));
  double yaw = random_.uniform(-0.35, 0.35);
  if (width_m < depth * std::abs(std::sin(yaw)) + 0.12) yaw = 0.0;
  const double across = (width_m - depth * std::abs(std::sin(yaw))) / std::cos(yaw);
  const bool stacked = shape > 0.8;
  const double lower = stacked ? random_.uniform(0.4, 0.7) * height_m : height_m;
  if (stacked) {
    Furniture upper = single("carton", boxPart({0.8 * depth, 0.8 * across}, lower, height_m - lower));
    upper.parts.front().outline.overhang = true;  // within the outline of the one below
    put(upper, {p.x(), p.y(), yaw}, "carton", paint(), {across, height_m - lower});
  }
  put(single("box", boxPart({depth, across}, 0.0, lower)), {p.x(), p.y(), yaw}, "box", look, {across, lower});
}

}  // namespace frugal_nav::eval
