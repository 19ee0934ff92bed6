#include "furniture.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include <frugal_nav/eval/random_world.hpp>

namespace frugal_nav::eval {
namespace {

/// A floor and its walls: counter-clockwise corners.
struct Plan {
  std::string kind;
  Polygon2 floor;
  Eigen::AlignedBox2d start_area;  ///< where the task may begin and end
  Eigen::AlignedBox2d goal_area;
  double pieces_per_m2 = 0.0;
  double along_walls = 0.5;  ///< share of the pieces that stand with their back to a wall
};

constexpr double kWallThickness_m = 0.1;

double areaOf(const Polygon2& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

bool contains(const Polygon2& polygon, const Eigen::Vector2d& p) {
  bool inside = false;  // crossings of the ray from p along +x
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

Eigen::AlignedBox2d boundsOf(const Polygon2& polygon) {
  Eigen::AlignedBox2d bounds;
  for (const Eigen::Vector2d& corner : polygon) bounds.extend(corner);
  return bounds;
}

Plan drawRoom(Random& random) {
  const double length = random.uniform(6.0, 9.0);
  const double width = random.uniform(5.0, 7.0);
  Plan plan;
  plan.kind = "room";
  plan.floor = {{0.0, 0.0}, {length, 0.0}, {length, width}, {0.0, width}};
  plan.start_area = {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.25 * length, width)};
  plan.goal_area = {Eigen::Vector2d(0.7 * length, 0.0), Eigen::Vector2d(length, width)};
  plan.pieces_per_m2 = random.uniform(0.38, 0.52);
  plan.along_walls = 0.25;
  return plan;
}

/// The corners of a wall from x = 0 to `length` at y = 0 that steps back to y < 0 in a niche or two.
Polygon2 wallWithNiches(double length, Random& random) {
  Polygon2 corners{{0.0, 0.0}};
  double x = random.uniform(0.8, 2.5);
  while (x + 1.6 < length) {
    const double width = random.uniform(0.7, 1.3);
    const double depth = random.uniform(0.3, 0.8);
    corners.insert(corners.end(), {{x, 0.0}, {x, -depth}, {x + width, -depth}, {x + width, 0.0}});
    x += width + random.uniform(1.5, 4.0);
  }
  return corners;
}

/// Appends a wall drawn by wallWithNiches at `world_from_wall`.
void append(const Pose2& world_from_wall, const Polygon2& wall, Polygon2& floor) {
  for (const Eigen::Vector2d& corner : wall) floor.push_back(world_from_wall * corner);
}

Plan drawCorridor(Random& random) {
  const double length = random.uniform(7.0, 10.0);
  const double width = random.uniform(1.7, 2.4);
  Plan plan;
  plan.kind = "corridor";
  append({0.0, 0.0, 0.0}, wallWithNiches(length, random), plan.floor);
  plan.floor.push_back({length, 0.0});
  append({length, width, M_PI}, wallWithNiches(length, random), plan.floor);
  plan.floor.push_back({0.0, width});
  plan.start_area = {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(1.5, width)};
  plan.goal_area = {Eigen::Vector2d(length - 2.0, 0.0), Eigen::Vector2d(length, width)};
  plan.pieces_per_m2 = random.uniform(0.35, 0.5);
  plan.along_walls = 0.55;
  return plan;
}

/// A corridor that turns left.
Plan drawBend(Random& random) {
  const double first = random.uniform(4.0, 6.0);   // outer length along x
  const double second = random.uniform(4.0, 6.0);  // outer length along y
  const double width = random.uniform(1.7, 2.4);
  Plan plan;
  plan.kind = "bend";
  append({0.0, 0.0, 0.0}, wallWithNiches(first, random), plan.floor);
  append({first, 0.0, M_PI_2}, wallWithNiches(second, random), plan.floor);
  plan.floor.push_back({first, second});
  plan.floor.push_back({first - width, second});
  plan.floor.push_back({first - width, width});
  plan.floor.push_back({0.0, width});
  plan.start_area = {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(1.2, width)};
  plan.goal_area = {Eigen::Vector2d(first - width, second - 1.2), Eigen::Vector2d(first, second)};
  plan.pieces_per_m2 = random.uniform(0.25, 0.4);
  plan.along_walls = 0.55;
  return plan;
}

Plan drawPlan(Random& random) {
  const double draw = random.uniform(0.0, 1.0);
  if (draw < 0.6) return drawRoom(random);
  return draw < 0.85 ? drawCorridor(random) : drawBend(random);
}

Furniture drawPiece(const Plan& plan, bool along_wall, Random& random) {
  const bool room = plan.kind == "room";
  switch (random.integer(0, 5)) {
    case 0:
      return room ? makeTable(random) : makeCarton(random);
    case 1:
      return along_wall ? makeCabinet(random) : makeChair(random);
    case 2:
      return along_wall ? makeShelf(random) : makeTable(random);
    case 3:
      return makeCarton(random);
    case 4:
      return room ? makeCabinet(random) : makeBin(random);
    default:
      return random.chance(0.5) ? makeBin(random) : makePillar(random);
  }
}

class Furnisher {
 public:
  Furnisher(const Plan& plan, Random& random) : plan_(plan), bounds_(boundsOf(plan.floor)), random_(random) {}

  void build(RandomWorld& world) {
    world.kind = plan_.kind;
    world.scene.name = plan_.kind;
    for (std::size_t i = 0; i < plan_.floor.size(); ++i) addWall(i, world);
    const int pieces = static_cast<int>(std::lround(plan_.pieces_per_m2 * areaOf(plan_.floor)));
    for (int i = 0; i < pieces; ++i) addPiece(i, world);
  }

 private:
  const Eigen::Vector2d& corner(std::size_t i) const { return plan_.floor[i % plan_.floor.size()]; }

  /// The pose whose x axis runs along an edge of the floor and whose y axis points inside.
  Pose2 edgePose(std::size_t edge, double along, double inward) const {
    const Eigen::Vector2d direction = corner(edge + 1) - corner(edge);
    const Pose2 world_from_edge{corner(edge).x(), corner(edge).y(), std::atan2(direction.y(), direction.x())};
    return world_from_edge * Pose2{along, inward, 0.0};
  }

  void addWall(std::size_t edge, RandomWorld& world) {
    const double length = (corner(edge + 1) - corner(edge)).norm();
    constexpr double kOverlap_m = 0.02;  // closes the joints at the corners
    place(makeWall(length + kOverlap_m), edgePose(edge, 0.5 * length, -0.5 * kWallThickness_m),
          "wall_" + std::to_string(edge), world.scene, world.solids);
  }

  void addPiece(int number, RandomWorld& world) {
    const bool along_wall = random_.chance(plan_.along_walls);
    const Furniture piece = drawPiece(plan_, along_wall, random_);
    for (int attempt = 0; attempt < 30; ++attempt) {
      const std::optional<Pose2> pose = along_wall ? drawWallPose(piece) : drawFloorPose();
      if (!pose || !fits(piece, *pose, world.solids)) continue;
      place(piece, *pose, piece.kind + "_" + std::to_string(number), world.scene, world.solids);
      return;
    }
  }

  Pose2 drawFloorPose() {
    const double x = random_.uniform(bounds_.min().x(), bounds_.max().x());
    const double y = random_.uniform(bounds_.min().y(), bounds_.max().y());
    return {x, y, random_.uniform(-M_PI, M_PI)};
  }

  std::optional<Pose2> drawWallPose(const Furniture& piece) {
    const auto edge = static_cast<std::size_t>(random_.integer(0, static_cast<int>(plan_.floor.size()) - 1));
    const double room = (corner(edge + 1) - corner(edge)).norm() - piece.size_m.x();
    const double along = random_.uniform(0.0, 1.0);
    if (room < 0.0) return std::nullopt;
    constexpr double kGap_m = 0.02;
    return edgePose(edge, 0.5 * piece.size_m.x() + along * room, 0.5 * piece.size_m.y() + kGap_m);
  }

  /// Whether a piece stands on the floor and clear of the others.
  bool fits(const Furniture& piece, const Pose2& pose, const std::vector<Solid>& solids) const {
    constexpr double kGap_m = 0.015;
    constexpr int kSteps = 12;  // points along each side of its rectangle
    for (int i = 0; i <= kSteps; ++i) {
      const double t = static_cast<double>(i) / kSteps - 0.5;
      for (const Eigen::Vector2d& unit : {Eigen::Vector2d(t, -0.5), Eigen::Vector2d(t, 0.5),
                                          Eigen::Vector2d(-0.5, t), Eigen::Vector2d(0.5, t)}) {
        const Eigen::Vector2d p = pose * Eigen::Vector2d(unit.cwiseProduct(piece.size_m));
        if (!contains(plan_.floor, p)) return false;
        for (const Solid& solid : solids) {
          if (solid.distanceTo(p) < kGap_m) return false;
        }
      }
    }
    const Solid rectangle{pose, piece.size_m, 0.0, false};
    return std::none_of(solids.begin(), solids.end(), [&](const Solid& solid) {
      return rectangle.distanceTo(solid.world_from_solid.position()) < kGap_m;
    });
  }

  const Plan& plan_;
  Eigen::AlignedBox2d bounds_;
  Random& random_;
};

std::optional<Pose2> drawFreePose(const Plan& plan, const Eigen::AlignedBox2d& area, const FreeSpace& space,
                                  Random& random) {
  for (int attempt = 0; attempt < 50; ++attempt) {
    const double x = random.uniform(area.min().x(), area.max().x());
    const double y = random.uniform(area.min().y(), area.max().y());
    const double yaw = random.uniform(-M_PI, M_PI);
    if (contains(plan.floor, {x, y}) && space.isFree({x, y})) return Pose2{x, y, yaw};
  }
  return std::nullopt;
}

std::optional<RandomWorld> drawWorld(Random& random, double disc_radius_m) {
  const Plan plan = drawPlan(random);
  RandomWorld world;
  Furnisher(plan, random).build(world);
  const FreeSpace space(boundsOf(plan.floor), world.solids, disc_radius_m);
  const std::optional<Pose2> start = drawFreePose(plan, plan.start_area, space, random);
  const std::optional<Pose2> goal = drawFreePose(plan, plan.goal_area, space, random);
  if (!start || !goal) return std::nullopt;
  const std::optional<double> length = space.pathLength(start->position(), goal->position());
  if (!length) return std::nullopt;
  world.start = *start;
  world.goal = *goal;
  world.path_length_m = *length;
  return world;
}

}  // namespace

RandomWorld makeRandomWorld(std::uint64_t seed, double disc_radius_m) {
  Random random(seed, "random_world");
  constexpr int kAttempts = 1000;  // about every second layout has a way through
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    std::optional<RandomWorld> world = drawWorld(random, disc_radius_m);
    if (world) return *world;
  }
  throw std::runtime_error("no random world lets a disc of " + std::to_string(disc_radius_m) + " m through");
}

}  // namespace frugal_nav::eval
