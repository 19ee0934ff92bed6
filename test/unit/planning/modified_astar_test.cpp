#include <cmath>
#include <limits>
#include <map>

#include <gtest/gtest.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/planning/modified_astar.hpp>

namespace frugal_nav {
namespace {

using Vec = Eigen::Vector2d;
using Status = ModifiedAStar::Result::Status;

constexpr double kInf = std::numeric_limits<double>::infinity();

ModifiedAStarParams paramsOf(const std::string& mode, double kappa = 2.0, double eta = 0.25) {
  ModifiedAStarParams params;
  params.mode = mode;
  params.kappa = kappa;
  params.eta = eta;
  params.detour_m = 1.0;
  return params;
}

double freeEverywhere(const Vec&) { return 1.0; }

/// Bellman and Ford's relaxation over all cells of 0.2 m with the goal straight up, written from the paper's
/// formulas alone: cost from (0, 0) to each cell of x in [-5, 5], y in [-5, goal_y + 5].
std::map<std::pair<int, int>, double> bruteForce(int goal_y, double h0, double kappa,
                                                 const ModifiedAStar::Cost& cost) {
  const double s = 0.2;
  std::map<std::pair<int, int>, double> g;
  const auto place = [&](int x, int y) {
    const bool inside = x >= -5 && x <= 5 && y >= -5 && y <= goal_y + 5;
    return inside ? cost({s * x, s * y}) : kInf;
  };
  g[{0, 0}] = 0.0;
  for (bool changed = true; changed;) {
    changed = false;
    for (int y = -5; y <= goal_y + 5; ++y) {
      for (int x = -5; x <= 5; ++x) {
        if (g.count({x, y}) == 0) continue;
        const double m = 1.0 + kappa * std::hypot(s * x, s * (goal_y - y)) / h0;
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            if (dx == 0 && dy == 0) continue;
            const double there = place(x + dx, y + dy);
            if (std::isinf(there) || std::isinf(place(x + dx, y)) || std::isinf(place(x, y + dy))) continue;
            const double step = dx == 0 ? 1.0 : dy == 0 ? m : std::sqrt(1.0 + m * m);
            const double through = g[{x, y}] + s * step * there;
            const auto known = g.find({x + dx, y + dy});
            if (known != g.end() && known->second <= through + 1e-12) continue;
            g[{x + dx, y + dy}] = through;
            changed = true;
          }
        }
      }
    }
  }
  return g;
}

TEST(ModifiedAStar, IsAsCheapAsBruteForce) {
  int found = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Random random(seed);
    std::map<std::pair<long, long>, double> places;
    const ModifiedAStar::Cost cost = [&](const Vec& p) {
      const std::pair<long, long> cell{std::lround(p.x() / 0.2), std::lround(p.y() / 0.2)};
      if (cell == std::pair<long, long>{0, 0} || cell == std::pair<long, long>{0, 12}) return 1.0;
      const auto known = places.find(cell);
      if (known != places.end()) return known->second;
      return places[cell] = random.chance(0.35) ? kInf : random.uniform(1.0, 4.0);
    };
    ModifiedAStar astar(paramsOf("default"));
    astar.startMission({0.0, -1.6}, {0.0, 2.4});
    const auto result = astar.plan({{0.0, 0.0}, {0.0, 2.4}, std::nullopt, 0.0}, cost);
    const auto expected = bruteForce(12, 4.0, 2.0, cost);
    const auto at_goal = expected.find({0, 12});
    ASSERT_EQ(result.status == Status::kFound, at_goal != expected.end()) << seed;
    if (at_goal == expected.end()) continue;
    ++found;
    EXPECT_NEAR(result.cost, at_goal->second, 1e-9) << seed;
    EXPECT_TRUE(result.reaches_goal);
    EXPECT_LT((result.points.back() - Vec(0.0, 2.4)).norm(), 1e-9);
  }
  EXPECT_GT(found, 15);
}

TEST(ModifiedAStar, MakesStepsAsideDearAtTheStartAndPlainAtTheGoal) {
  ModifiedAStar astar(paramsOf("default"));
  astar.startMission({1.0, 1.0}, {1.0, 5.0});
  EXPECT_DOUBLE_EQ(astar.horizontalFactor({1.0, 1.0}), 3.0);
  EXPECT_DOUBLE_EQ(astar.horizontalFactor({1.0, 3.0}), 2.0);
  EXPECT_DOUBLE_EQ(astar.horizontalFactor({1.0, 5.0}), 1.0);
}

TEST(ModifiedAStar, KeepsTheMissionsFirstDistanceWhenItReplansOrTheGoalMoves) {
  ModifiedAStar astar(paramsOf("default"));
  astar.startMission({0.0, 0.0}, {4.0, 0.0});
  const ModifiedAStar::Query near_goal{{3.0, 0.0}, {4.0, 0.0}, std::nullopt, 0.0};
  astar.plan(near_goal, freeEverywhere);
  EXPECT_DOUBLE_EQ(astar.horizontalFactor({3.0, 0.0}), 1.5);  // not 3, as if the mission began here
  astar.moveGoal({0.0, 4.4});
  EXPECT_DOUBLE_EQ(astar.horizontalFactor({0.0, 0.4}), 3.0);
  EXPECT_LT((astar.vertical() - Vec(0.0, 1.0)).norm(), 1e-12);
}

TEST(ModifiedAStar, TurnsItsGridWithTheMission) {
  // The same scene turned by any angle gives the same cost.
  const auto costOf = [](double yaw) {
    const Pose2 turn{0.7, -0.3, yaw};
    const ModifiedAStar::Cost wall = [&](const Vec& p) {
      const Vec q = turn.inverse() * p;
      return std::abs(q.x() - 1.0) < 0.15 && q.y() < 0.5 ? kInf : 1.0;
    };
    ModifiedAStar astar(paramsOf("default"));
    astar.startMission(turn * Vec(0.0, 0.0), turn * Vec(3.0, 0.0));
    return astar.plan({turn * Vec(0.0, 0.0), turn * Vec(3.0, 0.0), std::nullopt, 0.0}, wall).cost;
  };
  EXPECT_GT(costOf(0.0), 3.5);
  for (const double yaw : {0.4, 1.1, -2.5}) EXPECT_NEAR(costOf(yaw), costOf(0.0), 1e-9) << yaw;
}

TEST(ModifiedAStar, StaysOnItsLaneUntilNearTheGoal) {
  // From beside the line to the goal: the steps aside are left for the end, where they are cheap.
  ModifiedAStar astar(paramsOf("default"));
  astar.startMission({0.0, 0.0}, {0.0, 4.0});
  const auto late = astar.plan({{0.8, 0.0}, {0.0, 4.0}, std::nullopt, 0.0}, freeEverywhere);
  ASSERT_EQ(late.status, Status::kFound);
  for (const Vec& p : late.points) {
    if (p.y() < 2.9) {
      EXPECT_NEAR(p.x(), 0.8, 1e-9);
    }
  }
}

TEST(ModifiedAStar, GoesThroughAGapThatIsNoDetour) {
  const ModifiedAStar::Query query{{0.0, 0.0}, {0.0, 4.0}, Vec(0.4, 2.0), 0.0};
  ModifiedAStar generous(paramsOf("default", 2.0, 0.25));
  generous.startMission({0.0, 0.0}, {0.0, 4.0});
  const auto through = generous.plan(query, freeEverywhere);
  EXPECT_TRUE(through.through_gap);
  EXPECT_TRUE(through.reaches_goal);
  const auto has = [](const auto& result, const Vec& p) {
    for (const Vec& q : result.points) {
      if ((p - q).norm() < 1e-9) return true;
    }
    return false;
  };
  EXPECT_TRUE(has(through, {0.4, 2.0}));
  // Two steps aside and back are 4 diagonals: 4 m + 4 * 0.2 m * (sqrt(2) - 1) = 4.331 m, 8.3 % more.
  EXPECT_NEAR(through.length_m, 4.0 + 0.8 * (std::sqrt(2.0) - 1.0), 1e-9);
  ModifiedAStar strict(paramsOf("default", 2.0, 0.08));
  strict.startMission({0.0, 0.0}, {0.0, 4.0});
  const auto direct = strict.plan(query, freeEverywhere);
  EXPECT_FALSE(direct.through_gap);
  EXPECT_NEAR(direct.length_m, 4.0, 1e-9);
}

TEST(ModifiedAStar, IgnoresAGapThatLiesInAnObstacle) {
  ModifiedAStar astar(paramsOf("default"));
  astar.startMission({0.0, 0.0}, {0.0, 4.0});
  const ModifiedAStar::Cost cost = [](const Vec& p) { return (p - Vec(0.4, 2.0)).norm() < 0.3 ? kInf : 1.0; };
  const auto result = astar.plan({{0.0, 0.0}, {0.0, 4.0}, Vec(0.4, 2.0), 0.0}, cost);
  EXPECT_EQ(result.status, Status::kFound);
  EXPECT_FALSE(result.through_gap);
}

TEST(ModifiedAStar, LiteralErasesTheCostAtTheGapAndSoTakesDetours) {
  // Dear ground lies across the way. The gap lies in it, far off the line: the literal rule forgets there
  // what the ground has cost already.
  const ModifiedAStar::Query query{{0.0, 0.0}, {0.0, 2.0}, Vec(0.6, 0.8), 0.0};
  const ModifiedAStar::Cost cost = [](const Vec& p) { return p.y() > 0.5 && p.y() < 1.5 ? 8.0 : 1.0; };
  ModifiedAStar literal(paramsOf("literal"));
  literal.startMission({0.0, 0.0}, {0.0, 2.0});
  ModifiedAStar sound(paramsOf("default", 2.0, 0.2));
  sound.startMission({0.0, 0.0}, {0.0, 2.0});
  const auto erased = literal.plan(query, cost);
  const auto direct = sound.plan(query, cost);
  ASSERT_EQ(erased.status, Status::kFound);
  EXPECT_TRUE(erased.through_gap);
  EXPECT_FALSE(direct.through_gap);
  // Straight on: 2 m, of which five steps of 0.2 m are dear: 1 + 8. By the gap: six diagonals and four steps,
  // 2.50 m; it counts only what follows: three dear steps, 4.8, and three diagonals near the goal.
  EXPECT_NEAR(direct.cost, 9.0, 1e-9);
  EXPECT_NEAR(erased.length_m, 0.8 + 1.2 * std::sqrt(2.0), 1e-9);
  EXPECT_LT(erased.cost, 6.5);
}

TEST(ModifiedAStar, FailsClearly) {
  ModifiedAStar astar(paramsOf("default"));
  const ModifiedAStar::Query query{{0.0, 0.0}, {0.0, 2.0}, std::nullopt, 0.2};
  EXPECT_EQ(astar.plan(query, freeEverywhere).status, Status::kBadInput);  // no mission
  astar.startMission({0.0, 0.0}, {0.0, 2.0});
  EXPECT_EQ(astar.plan(query, freeEverywhere).status, Status::kFound);
  const auto wall = [](const Vec& p) { return std::abs(p.y() - 1.0) < 0.15 ? kInf : 1.0; };
  const auto closed = astar.plan(query, wall);
  EXPECT_EQ(closed.status, Status::kNoPath);
  EXPECT_TRUE(closed.points.empty());
  const auto buried = [](const Vec& p) { return (p - Vec(0.0, 2.0)).norm() < 0.5 ? kInf : 1.0; };
  EXPECT_EQ(astar.plan(query, buried).status, Status::kGoalBlocked);
  EXPECT_EQ(astar.plan({{0.0, 0.0}, {0.0, std::nan("")}, std::nullopt, 0.0}, freeEverywhere).status,
            Status::kBadInput);
  EXPECT_EQ(astar.plan({{0.0, 0.0}, {0.0, 1e9}, std::nullopt, 0.0}, freeEverywhere).status,
            Status::kBadInput);
  astar.endMission();
  EXPECT_EQ(astar.plan(query, freeEverywhere).status, Status::kBadInput);
}

TEST(ModifiedAStar, ReplacesABlockedGoalWithinTheTolerance) {
  ModifiedAStar astar(paramsOf("default"));
  astar.startMission({0.0, 0.0}, {0.0, 2.0});
  const auto blocked = [](const Vec& p) { return (p - Vec(0.0, 2.0)).norm() < 0.3 ? kInf : 1.0; };
  const auto result = astar.plan({{0.0, 0.0}, {0.0, 2.0}, std::nullopt, 0.45}, blocked);
  ASSERT_EQ(result.status, Status::kFound);
  EXPECT_FALSE(result.reaches_goal);
  EXPECT_NEAR((result.points.back() - Vec(0.0, 2.0)).norm(), 0.4, 1e-9);
}

TEST(ModifiedAStar, StraightensWithoutCuttingThroughObstacles) {
  ModifiedAStar astar(paramsOf("default", 0.0));
  astar.startMission({0.0, 0.0}, {1.0, 3.0});
  const ModifiedAStar::Cost cost = [](const Vec& p) { return (p - Vec(0.5, 1.5)).norm() < 0.5 ? kInf : 1.0; };
  const auto result = astar.plan({{0.0, 0.0}, {1.0, 3.0}, std::nullopt, 0.0}, cost);
  const std::vector<Vec> corners = astar.straighten(result.points, cost);
  EXPECT_LT(corners.size(), result.points.size() / 2);
  double length = 0.0;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    length += (corners[i] - corners[i - 1]).norm();
    for (double f = 0.0; f <= 1.0; f += 0.01)
      EXPECT_TRUE(std::isfinite(cost(corners[i - 1] + f * (corners[i] - corners[i - 1])))) << i;
  }
  EXPECT_LE(length, result.length_m + 1e-9);
}

}  // namespace
}  // namespace frugal_nav
