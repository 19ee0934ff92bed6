#include <limits>
#include <queue>

#include <gtest/gtest.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/planning/astar.hpp>

namespace frugal_nav {
namespace {

using Status = AStarResult::Status;

WeightGrid freeGrid(int size) {
  return {size, std::vector<std::uint16_t>(static_cast<std::size_t>(size * size), WeightGrid::kFree)};
}

void setWeight(WeightGrid& grid, Cell cell, int weight) {
  grid.weights[grid.index(cell)] = static_cast<std::uint16_t>(weight);
}

WeightGrid randomGrid(Random& random, int size, double lethal_share) {
  WeightGrid grid = freeGrid(size);
  for (auto& weight : grid.weights) {
    const int drawn = random.chance(lethal_share) ? WeightGrid::kLethal
                                                  : random.integer(WeightGrid::kFree, WeightGrid::kHighest);
    weight = static_cast<std::uint16_t>(drawn);
  }
  return grid;
}

bool isStep(const WeightGrid& grid, Cell from, Cell to) {
  const int dx = to.x - from.x;
  const int dy = to.y - from.y;
  if (std::abs(dx) > 1 || std::abs(dy) > 1 || (dx == 0 && dy == 0)) return false;
  return grid.isPassable(to) &&
         (dx == 0 || dy == 0 || (grid.isPassable({to.x, from.y}) && grid.isPassable({from.x, to.y})));
}

/// The plain algorithm of 1959, written independently: cost of every cell, -1 where it cannot be reached.
std::vector<int> dijkstra(const WeightGrid& grid, Cell start) {
  std::vector<int> best(grid.weights.size(), -1);
  using Entry = std::pair<int, std::pair<int, int>>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  open.push({0, {start.x, start.y}});
  while (!open.empty()) {
    const auto [cost, place] = open.top();
    open.pop();
    const Cell cell{place.first, place.second};
    if (best[grid.index(cell)] >= 0) continue;
    best[grid.index(cell)] = cost;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Cell next{cell.x + dx, cell.y + dy};
        if (!isStep(grid, cell, next)) continue;
        open.push({cost + stepCost(grid.weights[grid.index(next)], dx != 0 && dy != 0), {next.x, next.y}});
      }
    }
  }
  return best;
}

int costAlong(const WeightGrid& grid, const std::vector<Cell>& cells) {
  int cost = 0;
  for (std::size_t i = 1; i < cells.size(); ++i) {
    const bool diagonal = cells[i].x != cells[i - 1].x && cells[i].y != cells[i - 1].y;
    cost += stepCost(grid.weights[grid.index(cells[i])], diagonal);
  }
  return cost;
}

TEST(AStar, CostsWhatDijkstraCosts) {
  Random random(500001);
  AStar astar;
  int found = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int size = random.integer(5, 60);
    WeightGrid grid = randomGrid(random, size, random.uniform(0.0, 0.45));
    const Cell start{random.integer(0, size - 1), random.integer(0, size - 1)};
    const Cell goal{random.integer(0, size - 1), random.integer(0, size - 1)};
    setWeight(grid, start, WeightGrid::kFree);
    setWeight(grid, goal, WeightGrid::kFree);
    const int expected = dijkstra(grid, start)[grid.index(goal)];
    const AStarResult result = astar.search(grid, start, goal, 0.0);
    ASSERT_EQ(result.status == Status::kFound, expected >= 0) << "trial " << trial;
    if (expected < 0) continue;
    ++found;
    ASSERT_EQ(result.cost, expected) << "trial " << trial;
    ASSERT_EQ(costAlong(grid, result.cells), expected);
    ASSERT_EQ(result.cells.front(), start);
    ASSERT_EQ(result.cells.back(), goal);
    for (std::size_t i = 1; i < result.cells.size(); ++i) {
      ASSERT_TRUE(isStep(grid, result.cells[i - 1], result.cells[i])) << "trial " << trial;
    }
  }
  EXPECT_GT(found, 100);
}

TEST(AStar, LeavesTheWindowWhereTheWholeWayIsShortest) {
  Random random(500002);
  AStar astar;
  for (int trial = 0; trial < 100; ++trial) {
    const int size = 40;
    WeightGrid grid = randomGrid(random, size, random.uniform(0.0, 0.3));
    const Cell start{20, 20};
    setWeight(grid, start, WeightGrid::kFree);
    const Cell goal{random.integer(45, 120), random.integer(-80, 120)};
    const std::vector<int> best = dijkstra(grid, start);
    int expected = std::numeric_limits<int>::max();
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const bool border = x == 0 || y == 0 || x == size - 1 || y == size - 1;
        const int cost = best[grid.index({x, y})];
        if (border && cost >= 0) expected = std::min(expected, cost + octileCost({x, y}, goal));
      }
    }
    const AStarResult result = astar.search(grid, start, goal, 0.0);
    ASSERT_EQ(result.status == Status::kFound, expected < std::numeric_limits<int>::max());
    if (result.status != Status::kFound) continue;
    EXPECT_TRUE(result.leaves_window);
    ASSERT_EQ(result.cost + octileCost(result.cells.back(), goal), expected) << "trial " << trial;
  }
}

TEST(AStar, DoesNotCutCorners) {
  WeightGrid grid = freeGrid(5);
  setWeight(grid, {2, 1}, WeightGrid::kLethal);
  AStar astar;
  const AStarResult result = astar.search(grid, {1, 1}, {2, 2}, 0.0);
  // Down beside the corner and then across: 20 + 20, not the diagonal's 28.
  EXPECT_EQ(result.cost, 40);
  setWeight(grid, {1, 2}, WeightGrid::kLethal);
  setWeight(grid, {1, 0}, WeightGrid::kLethal);
  setWeight(grid, {0, 1}, WeightGrid::kLethal);
  EXPECT_EQ(astar.search(grid, {1, 1}, {2, 2}, 0.0).status, Status::kNoPath);
}

TEST(AStar, SameInputGivesSamePath) {
  Random random(500003);
  const WeightGrid grid = freeGrid(50);  // many equal paths
  AStar used;
  for (int i = 0; i < 20; ++i) {
    used.search(randomGrid(random, 50, 0.2), {25, 25}, {3, 4}, 0.0);
    AStar fresh;
    const AStarResult a = used.search(grid, {2, 3}, {40, 20}, 0.0);
    const AStarResult b = fresh.search(grid, {2, 3}, {40, 20}, 0.0);
    ASSERT_TRUE(a.cells == b.cells);
  }
}

TEST(AStar, TakesTheNearestReachableCellForABlockedGoal) {
  WeightGrid grid = freeGrid(20);
  for (int y = 5; y <= 9; ++y) {
    for (int x = 10; x <= 14; ++x) setWeight(grid, {x, y}, WeightGrid::kLethal);
  }
  AStar astar;
  const AStarResult result = astar.search(grid, {2, 7}, {11, 7}, 2.5);
  ASSERT_EQ(result.status, Status::kFound);
  EXPECT_EQ(result.cells.back(), (Cell{9, 7}));
  EXPECT_EQ(astar.search(grid, {2, 7}, {12, 7}, 2.5).status, Status::kGoalBlocked);
}

TEST(AStar, SettlesForTheNearSideOfAWall) {
  WeightGrid grid = freeGrid(20);
  for (int y = 0; y < 20; ++y) setWeight(grid, {10, y}, WeightGrid::kLethal);
  AStar astar;
  EXPECT_EQ(astar.search(grid, {2, 7}, {11, 7}, 1.0).status, Status::kNoPath);
  const AStarResult result = astar.search(grid, {2, 7}, {11, 7}, 2.0);
  ASSERT_EQ(result.status, Status::kFound);
  EXPECT_EQ(result.cells.back(), (Cell{9, 7}));
}

TEST(AStar, StartOutsideFindsNothing) {
  AStar astar;
  EXPECT_EQ(astar.search(freeGrid(10), {-1, 3}, {5, 5}, 0.0).status, Status::kNoPath);
}

TEST(AStar, StartAtTheGoalIsAPathOfOneCell) {
  AStar astar;
  const AStarResult result = astar.search(freeGrid(10), {4, 4}, {4, 4}, 0.0);
  EXPECT_EQ(result.cost, 0);
  EXPECT_EQ(result.cells.size(), 1U);
}

}  // namespace
}  // namespace frugal_nav
