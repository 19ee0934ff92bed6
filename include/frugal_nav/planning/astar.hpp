#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <frugal_nav/planning/rolling_grid.hpp>

namespace frugal_nav {

/// A square of traversal weights, indexed from its own corner (0, 0).
struct WeightGrid {
  static constexpr int kFree = 20;       ///< weight of a cell that costs its length only
  static constexpr int kHighest = 320;   ///< sixteen times that
  static constexpr int kLethal = 65535;  ///< never entered

  int size = 0;
  std::vector<std::uint16_t> weights;  ///< rows of x; kFree .. kHighest, or kLethal

  std::size_t index(Cell cell) const { return static_cast<std::size_t>(cell.y * size + cell.x); }
  bool contains(Cell cell) const { return cell.x >= 0 && cell.y >= 0 && cell.x < size && cell.y < size; }
  bool isPassable(Cell cell) const { return contains(cell) && weights[index(cell)] != kLethal; }
};

/// Cost of a step into a cell of that weight: 1 along an axis, 1.4 along a diagonal, times the weight.
inline int stepCost(int weight, bool diagonal) { return diagonal ? weight * 7 / 5 : weight; }

/// Lowest possible cost between two cells: the octile distance over free cells.
int octileCost(Cell from, Cell to);

struct AStarResult {
  enum class Status {
    kFound,
    kGoalBlocked,  ///< no passable cell within the tolerance around the goal
    kNoPath,       ///< everything reachable was searched
  };
  Status status = Status::kNoPath;
  std::vector<Cell> cells;     ///< from the start to the cell reached, both included
  int cost = 0;                ///< sum of the step costs
  bool leaves_window = false;  ///< the goal lies outside: the path ends at the border
};

/// Shortest paths on a weight grid (Hart, Nilsson, Raphael 1968), 8-connected, without cutting corners.
///
/// All costs are integers and the heuristic is consistent, so the open list is an array of buckets, one a
/// cost (Dial 1969); within a bucket the last in is the first out. Same input, same path. A goal outside the
/// window is a node joined to every border cell at its octile distance, so that the path leaves the window
/// where the whole way is shortest. The buffers are kept between searches.
class AStar {
 public:
  /// `goal` may lie outside; inside, a passable cell within `tolerance_cells` of it will do when it cannot be
  /// reached itself: the nearest to it.
  AStarResult search(const WeightGrid& grid, Cell start, Cell goal, double tolerance_cells);

  /// Cells taken from the open list by the last search.
  int expanded() const { return expanded_; }

 private:
  struct Node {
    std::int32_t cost = 0;
    std::int16_t parent = 0;  ///< direction the cell was entered in
    bool closed = false;
    std::uint32_t search = 0;  ///< number of the search this entry belongs to
  };

  void prepare(const WeightGrid& grid);
  void open(std::size_t cell, int cost, int estimate, int direction);
  bool next(int& at, int last_estimate);
  void expand(const WeightGrid& grid, Cell cell, Cell goal);
  bool run(const WeightGrid& grid, Cell start, Cell goal, bool goal_inside, Cell& reached);
  bool nearestClosed(const WeightGrid& grid, Cell goal, double tolerance_cells, Cell& nearest) const;
  std::vector<Cell> trace(const WeightGrid& grid, Cell start, Cell end) const;
  Node& node(std::size_t cell);

  std::vector<Node> nodes_;
  std::vector<std::vector<std::pair<std::int32_t, std::int32_t>>>
      buckets_;  ///< (cell, its cost), by estimate
  int waiting_ = 0;
  int expanded_ = 0;
  std::uint32_t search_number_ = 0;
};

}  // namespace frugal_nav
