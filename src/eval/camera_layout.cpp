#include "camera_room.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <frugal_nav/eval/camera_layout.hpp>
#include <frugal_nav/sim/people.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>

namespace frugal_nav::eval {
namespace {

// Gaps in robot widths, as the evaluation asks for them.
constexpr double kNarrowest = 1.5;
constexpr double kWidest = 4.0;
// Half a cell's diagonal: what the grid of FreeSpace may be wrong by.
constexpr double kGridSlack_m = 0.036;
// Where the robot's camera is at the start.
const Eigen::Vector3d kCamera(0.1, 0.0, 0.4);

/// A row of obstacles across the way: what stands in it, from right (-y) to left.
struct Row {
  double x_m = 0.0;
  double right_m = 0.0;  ///< where its outermost gaps end: something solid has to stand there
  double left_m = 0.0;
  struct Piece {
    double y_m;
    double width_m;
  };
  std::vector<Piece> pieces;
};

class Builder {
 public:
  Builder(std::uint64_t seed, double robot_width_m, const std::vector<sim::Texture>& textures, Random& random)
      : seed_(seed), robot_width_m_(robot_width_m), random_(random), room_(textures, random, layout_.scene) {}

  /// Nothing when the draw did not work out.
  std::optional<CameraLayout> build() {
    const double to_person = random_.uniform(4.0, 7.0);
    layout_.start = {0.0, 0.0, random_.uniform(-0.2, 0.2)};
    layout_.p_person = {to_person, 0.0};
    layout_.p_stand_off = {to_person - kStandOff_m, 0.0};
    layout_.distance_m = to_person - kStandOff_m;
    const int obstacles = random_.integer(1, 3);
    const int in_row = random_.integer(1, obstacles);
    const Row row = drawRow(in_row, to_person);
    drawFloor(row, to_person);
    if (random_.chance(0.5) && !drawCrossing(row, to_person)) return std::nullopt;
    buildRoom(row);
    for (const Row::Piece& piece : row.pieces) addObstacle({row.x_m, piece.y_m}, piece.width_m, to_person);
    for (int i = in_row; i < obstacles; ++i) {
      if (!addLooseObstacle(row, to_person)) return std::nullopt;
    }
    addPeople();
    drawLight();
    layout_.solids = room_.solids;
    if (!hasWay() || !seesHead()) return std::nullopt;
    return std::move(layout_);
  }

 private:
  double drawGap() { return robot_width_m_ * random_.uniform(kNarrowest, kWidest); }

  Row drawRow(int count, double to_person) {
    Row row;
    row.x_m = to_person * random_.uniform(0.35, 0.6);
    const int blocking = random_.integer(0, count - 1);
    double left = 0.0;
    double right = 0.0;
    {
      const double width = random_.uniform(0.2, 1.0);
      const double right_share = random_.uniform(0.25, 0.75);
      right = -right_share * width;
      left = right + width;
      row.pieces.push_back({0.5 * (left + right), width});
    }
    for (int i = 0; i < count; ++i) {
      if (i == blocking) continue;
      const double width = random_.uniform(0.2, 1.0);
      const double gap = drawGap();
      if (i < blocking) {
        right -= gap + width;
        row.pieces.push_back({right + 0.5 * width, width});
      } else {
        left += gap + width;
        row.pieces.push_back({left - 0.5 * width, width});
      }
    }
    row.right_m = right - drawGap();
    row.left_m = left + drawGap();
    return row;
  }

  void drawFloor(const Row& row, double to_person) {
    constexpr double kNarrowestRoom_m = 2.0;
    const double row_width = row.left_m - row.right_m;
    const double wanted =
        std::max(kNarrowestRoom_m, row_width) + (random_.chance(0.5) ? random_.uniform(0.0, 1.5) : 0.0);
    const double share = random_.uniform(0.3, 0.7);
    double right = row.right_m - share * (wanted - row_width);
    double left = right + wanted;
    constexpr double kBesidePerson_m = 0.7;
    right = std::min(right, -kBesidePerson_m);
    left = std::max(left, kBesidePerson_m);
    layout_.floor = {Eigen::Vector2d(-random_.uniform(1.0, 2.0), right),
                     Eigen::Vector2d(to_person + random_.uniform(0.9, 2.5), left)};
  }

  bool drawCrossing(const Row& row, double to_person) {
    // Far enough from the row to pass, from the start to be met under way, and from the person to end behind.
    constexpr double kFromRow_m = 0.9;
    constexpr double kEarliest_m = 1.6;
    constexpr double kBeforePerson_m = 1.5;
    std::vector<std::pair<double, double>> spans;
    const auto consider = [&](double from, double to) {
      if (to > from) spans.emplace_back(from, to);
    };
    consider(kEarliest_m, row.x_m - kFromRow_m);
    consider(row.x_m + kFromRow_m, to_person - kBeforePerson_m);
    if (spans.empty()) return false;
    const auto& [from, to] =
        spans[static_cast<std::size_t>(random_.integer(0, static_cast<int>(spans.size()) - 1))];
    Crossing crossing;
    crossing.x_m = random_.uniform(from, to);
    crossing.speed_mps = random_.uniform(0.3, 1.0);
    crossing.lead_m = random_.uniform(0.8, 1.3);
    constexpr double kBehindDoor_m = 0.55;
    crossing.from_y_m = layout_.floor.min().y() - kBehindDoor_m;
    crossing.to_y_m = layout_.floor.max().y() + kBehindDoor_m;
    if (random_.chance(0.5)) std::swap(crossing.from_y_m, crossing.to_y_m);
    layout_.crossing = crossing;
    return true;
  }

  void buildRoom(const Row& row) {
    const std::optional<double> door =
        layout_.crossing ? std::optional<double>(layout_.crossing->x_m) : std::nullopt;
    room_.build(layout_.floor, door);
    room_.closeRow(row.x_m, layout_.floor.min().y(), row.right_m);
    room_.closeRow(row.x_m, row.left_m, layout_.floor.max().y());
    constexpr double kBehindPerson_m = 0.5;
    room_.furnish(row.right_m, row.left_m, layout_.p_person.x() + kBehindPerson_m, row.x_m);
  }

  /// The tallest thing that hides nothing of a head from the start.
  double sightHeight(double x_m, double to_person) const {
    constexpr double kLowestChin_m = 1.35;
    return kCamera.z() + (kLowestChin_m - kCamera.z()) * x_m / to_person - 0.05;
  }

  void addObstacle(const Eigen::Vector2d& p, double width_m, double to_person) {
    const bool on_line = std::abs(p.y()) < 0.5 * width_m + 0.3;
    const double tallest = on_line ? std::min(1.2, sightHeight(p.x() - 0.3, to_person)) : 1.2;
    room_.addObstacle(p, width_m, random_.uniform(0.25, tallest));
    layout_.obstacles.push_back(room_.solids.back());
  }

  bool addLooseObstacle(const Row& row, double to_person) {
    constexpr int kAttempts = 40;
    constexpr double kFromStart_m = 1.0;
    constexpr double kFromPerson_m = 1.5;  // leaves the stand-off point free
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const double width = random_.uniform(0.2, 1.0);
      const double x = random_.uniform(kFromStart_m, to_person);
      // Beside a wall or what stands there, a gap away.
      const bool left = random_.chance(0.5);
      const double edge = left ? row.left_m - drawGap() - 0.5 * width : row.right_m + drawGap() + 0.5 * width;
      const Eigen::Vector2d p(x, edge);
      if ((p - layout_.p_person).norm() < kFromPerson_m + 0.5 * width && x < to_person + 1.0) continue;
      if (p.norm() < kFromStart_m + 0.5 * width) continue;
      if (layout_.crossing && std::abs(x - layout_.crossing->x_m) < 0.6) continue;
      const double reach = 0.5 * width + 0.1;
      const double least = kNarrowest * robot_width_m_;
      const bool clear = std::all_of(room_.solids.begin(), room_.solids.end(), [&](const Solid& solid) {
        for (const double side : {-1.0, 0.0, 1.0}) {
          if (solid.distanceTo(p + Eigen::Vector2d(0.0, side * 0.5 * width)) <
              least + (side == 0.0 ? 0.5 * reach : 0.0))
            return false;
        }
        return true;
      });
      if (!clear) continue;
      addObstacle(p, width, to_person);
      return true;
    }
    return false;
  }

  void addPeople() {
    sim::Person goal;
    goal.name = "goal_person";
    goal.appearance = seed_ * 2 + 1;
    goal.waypoints.push_back(
        {0.0, Pose2{layout_.p_person.x(), layout_.p_person.y(), random_.uniform(-M_PI, M_PI)}});
    layout_.scene.people.push_back(goal);
    if (!layout_.crossing) return;
    const Crossing& crossing = *layout_.crossing;
    sim::Person walker;
    walker.name = "walker";
    walker.posture = sim::Posture::kWalking;
    walker.appearance = seed_ * 2 + 2;
    const double way_m = crossing.to_y_m - crossing.from_y_m;
    const double yaw = std::copysign(M_PI_2, way_m);
    walker.waypoints.push_back({0.0, Pose2{crossing.x_m, crossing.from_y_m, yaw}});
    walker.waypoints.push_back(
        {std::abs(way_m) / crossing.speed_mps, Pose2{crossing.x_m, crossing.to_y_m, yaw}});
    walker.loop = false;
    constexpr double kNever_s = 1e6;  // until the robot has come near
    walker.start_delay_s = kNever_s;
    layout_.scene.people.push_back(walker);
  }

  void drawLight() {
    constexpr const char* kLights[] = {"daylight", "dim", "tube"};
    layout_.light = kLights[random_.integer(0, 2)];
  }

  bool hasWay() {
    const auto passes = [&](double width_m) {
      const FreeSpace space(layout_.floor, layout_.solids, 0.5 * width_m);
      return space.pathLength({0.0, 0.0}, layout_.p_stand_off).has_value();
    };
    if (!passes(kNarrowest * robot_width_m_ - kGridSlack_m)) return false;
    if (passes(kWidest * robot_width_m_ + 2.0 * kGridSlack_m)) return false;
    double low = kNarrowest * robot_width_m_ - kGridSlack_m;
    double high = kWidest * robot_width_m_ + 2.0 * kGridSlack_m;
    while (high - low > 0.01) {
      const double middle = 0.5 * (low + high);
      (passes(middle) ? low : high) = middle;
    }
    layout_.gap_m = low;
    return true;
  }

  /// Whether most of the head is in sight from where the robot starts.
  bool seesHead() const {
    sim::Scene scene = layout_.scene;
    const std::vector<sim::PersonBody> bodies = sim::addPeople(scene);
    const sim::RayTracer tracer(scene);
    const sim::PersonBody& body = bodies[kGoalPerson];
    const Eigen::Vector3d middle(layout_.p_person.x(), layout_.p_person.y(), body.height_m - 0.12);
    for (const Eigen::Vector3d& aside :
         {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.0, 0.07, 0.0), Eigen::Vector3d(0.0, -0.07, 0.0),
          Eigen::Vector3d(0.0, 0.0, 0.09), Eigen::Vector3d(0.0, 0.0, -0.09)}) {
      const Eigen::Vector3d line = middle + aside - kCamera;
      constexpr double kHeadRadius_m = 0.15;
      if (tracer.range(kCamera, line, line.norm() - kHeadRadius_m)) return false;
    }
    return true;
  }

  std::uint64_t seed_;
  double robot_width_m_;
  Random& random_;
  CameraLayout layout_;
  CameraRoom room_;
};

}  // namespace

CameraLayout makeCameraLayout(std::uint64_t seed, double robot_width_m,
                              const std::vector<sim::Texture>& textures) {
  Random random(seed, "camera layout");
  constexpr int kAttempts = 300;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (auto layout = Builder(seed, robot_width_m, textures, random).build()) return *layout;
  }
  throw std::runtime_error("no layout could be drawn from the seed " + std::to_string(seed));
}

}  // namespace frugal_nav::eval
