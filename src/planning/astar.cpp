#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>

#include <frugal_nav/planning/astar.hpp>

namespace frugal_nav {
namespace {

constexpr std::array<Cell, 8> kSteps{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
constexpr int kFirstDiagonal = 4;
// An estimate grows by at most the dearest step plus the loss of one diagonal step of heuristic, 448 + 28: so
// the buckets in use never span more than this.
constexpr int kBuckets = 512;

bool isBorder(const WeightGrid& grid, Cell cell) {
  return cell.x == 0 || cell.y == 0 || cell.x == grid.size - 1 || cell.y == grid.size - 1;
}

/// The cells within a radius, nearest first; equal ones in the order of their indices.
std::vector<Cell> disc(Cell center, double radius_cells) {
  const int reach = static_cast<int>(std::ceil(radius_cells));
  const auto squared = [center](Cell c) {
    return (c.x - center.x) * (c.x - center.x) + (c.y - center.y) * (c.y - center.y);
  };
  std::vector<Cell> cells;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      const Cell cell{center.x + x, center.y + y};
      if (squared(cell) <= radius_cells * radius_cells) cells.push_back(cell);
    }
  }
  std::stable_sort(cells.begin(), cells.end(),
                   [&squared](Cell a, Cell b) { return squared(a) < squared(b); });
  return cells;
}

}  // namespace

int octileCost(Cell from, Cell to) {
  const int dx = std::abs(to.x - from.x);
  const int dy = std::abs(to.y - from.y);
  const int diagonal = std::min(dx, dy);
  return WeightGrid::kFree * (std::max(dx, dy) - diagonal) + stepCost(WeightGrid::kFree, true) * diagonal;
}

AStarResult AStar::search(const WeightGrid& grid, Cell start, Cell goal, double tolerance_cells) {
  AStarResult result;
  expanded_ = 0;
  if (!grid.contains(start)) return result;
  const bool inside = grid.contains(goal);
  Cell target = goal;
  if (inside && !grid.isPassable(goal)) {
    const std::vector<Cell> around = disc(goal, tolerance_cells);
    const auto free = std::find_if(around.begin(), around.end(), [&](Cell c) { return grid.isPassable(c); });
    if (free == around.end()) {
      result.status = AStarResult::Status::kGoalBlocked;
      return result;
    }
    target = *free;
  }
  prepare(grid);
  Cell reached = target;
  const bool found = run(grid, start, target, inside, reached) ||
                     (inside && nearestClosed(grid, goal, tolerance_cells, reached));
  if (!found) return result;
  result.status = AStarResult::Status::kFound;
  result.cells = trace(grid, start, reached);
  result.cost = node(grid.index(reached)).cost;
  result.leaves_window = !inside;
  return result;
}

void AStar::prepare(const WeightGrid& grid) {
  nodes_.resize(static_cast<std::size_t>(grid.size) * static_cast<std::size_t>(grid.size));
  buckets_.resize(kBuckets);
  for (auto& bucket : buckets_) bucket.clear();
  waiting_ = 0;
  ++search_number_;
}

AStar::Node& AStar::node(std::size_t cell) {
  Node& found = nodes_[cell];
  if (found.search != search_number_) found = {0, -1, false, search_number_};
  return found;
}

void AStar::open(std::size_t cell, int cost, int estimate, int direction) {
  Node& opened = node(cell);
  opened.cost = cost;
  opened.parent = static_cast<std::int16_t>(direction);
  buckets_[static_cast<std::size_t>((cost + estimate) % kBuckets)].emplace_back(
      static_cast<std::int32_t>(cell), cost);
  ++waiting_;
}

/// Moves on to the lowest estimate that something waits at; false when nothing does.
bool AStar::next(int& at, int last_estimate) {
  if (waiting_ == 0) return false;
  at = last_estimate;
  while (buckets_[static_cast<std::size_t>(at % kBuckets)].empty()) ++at;
  return true;
}

bool AStar::run(const WeightGrid& grid, Cell start, Cell goal, bool goal_inside, Cell& reached) {
  int estimate = octileCost(start, goal);
  open(grid.index(start), 0, estimate, -1);
  while (next(estimate, estimate)) {
    auto& bucket = buckets_[static_cast<std::size_t>(estimate % kBuckets)];
    const auto [index, cost] = bucket.back();
    bucket.pop_back();
    --waiting_;
    Node& current = node(static_cast<std::size_t>(index));
    if (current.closed || cost != current.cost) continue;  // a cheaper way was found meanwhile
    current.closed = true;
    ++expanded_;
    const Cell cell{index % grid.size, index / grid.size};
    // Outside the window only the octile distance counts, which is the estimate itself: the first border
    // cell taken from the list is where the whole way is shortest.
    if (goal_inside ? cell == goal : isBorder(grid, cell)) {
      reached = cell;
      return true;
    }
    expand(grid, cell, goal);
  }
  return false;
}

void AStar::expand(const WeightGrid& grid, Cell cell, Cell goal) {
  const int cost = node(grid.index(cell)).cost;
  for (int direction = 0; direction < static_cast<int>(kSteps.size()); ++direction) {
    const Cell step = kSteps[static_cast<std::size_t>(direction)];
    const Cell neighbour{cell.x + step.x, cell.y + step.y};
    if (!grid.isPassable(neighbour)) continue;
    const bool diagonal = direction >= kFirstDiagonal;
    if (diagonal && !(grid.isPassable({neighbour.x, cell.y}) && grid.isPassable({cell.x, neighbour.y})))
      continue;
    const std::size_t index = grid.index(neighbour);
    const int through = cost + stepCost(grid.weights[index], diagonal);
    const Node& known = node(index);
    if (known.closed || (known.parent >= 0 && known.cost <= through)) continue;
    open(index, through, octileCost(neighbour, goal), direction);
  }
}

bool AStar::nearestClosed(const WeightGrid& grid, Cell goal, double tolerance_cells, Cell& nearest) const {
  for (const Cell cell : disc(goal, tolerance_cells)) {
    if (!grid.contains(cell)) continue;
    const Node& seen = nodes_[grid.index(cell)];
    if (seen.search != search_number_ || !seen.closed) continue;
    nearest = cell;
    return true;
  }
  return false;
}

std::vector<Cell> AStar::trace(const WeightGrid& grid, Cell start, Cell end) const {
  std::vector<Cell> cells{end};
  while (cells.back() != start) {
    const int direction = nodes_[grid.index(cells.back())].parent;
    const Cell step = kSteps[static_cast<std::size_t>(direction)];
    cells.push_back({cells.back().x - step.x, cells.back().y - step.y});
  }
  std::reverse(cells.begin(), cells.end());
  return cells;
}

}  // namespace frugal_nav
