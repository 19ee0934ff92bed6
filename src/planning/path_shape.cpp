#include <algorithm>
#include <cmath>
#include <limits>

#include <frugal_nav/planning/path_shape.hpp>

namespace frugal_nav {
namespace {

// The line's cost is sampled, the run's is summed over its cells: they differ by rounding, not by the way.
constexpr double kTolerance = 1.03;

/// Weight integrated along the straight line between two cell centres; infinite where it is not passable.
double lineCost(const WeightGrid& grid, Cell from, Cell to) {
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  const int samples = std::max(1, static_cast<int>(std::ceil(2.0 * length)));
  double sum = 0.0;
  for (int i = 1; i <= samples; ++i) {
    const double f = static_cast<double>(i) / samples;
    const Cell cell{static_cast<int>(std::lround(from.x + f * (to.x - from.x))),
                    static_cast<int>(std::lround(from.y + f * (to.y - from.y)))};
    if (!grid.isPassable(cell)) return std::numeric_limits<double>::infinity();
    sum += grid.weights[grid.index(cell)];
  }
  return sum * length / samples;
}

double stepCostExact(const WeightGrid& grid, Cell from, Cell to) {
  return grid.weights[grid.index(to)] * std::hypot(to.x - from.x, to.y - from.y);
}

}  // namespace

std::vector<Cell> straighten(const WeightGrid& grid, const std::vector<Cell>& cells) {
  if (cells.size() < 3) return cells;
  std::vector<Cell> corners{cells.front()};
  std::size_t from = 0;
  while (from + 1 < cells.size()) {
    std::size_t to = from + 1;
    double run = stepCostExact(grid, cells[from], cells[to]);
    while (to + 1 < cells.size()) {
      run += stepCostExact(grid, cells[to], cells[to + 1]);
      if (lineCost(grid, cells[from], cells[to + 1]) > kTolerance * run) break;
      ++to;
    }
    corners.push_back(cells[to]);
    from = to;
  }
  return corners;
}

Path2 resample(const std::vector<Eigen::Vector2d>& corners, double spacing_m, double single_yaw_rad) {
  Path2 path;
  if (corners.empty()) return path;
  double yaw = single_yaw_rad;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Eigen::Vector2d line = corners[i + 1] - corners[i];
    const double length = line.norm();
    if (length < 1e-9) continue;
    yaw = std::atan2(line.y(), line.x());
    const int pieces = std::max(1, static_cast<int>(std::ceil(length / spacing_m - 1e-9)));
    for (int k = 0; k < pieces; ++k) {
      const Eigen::Vector2d p = corners[i] + line * (static_cast<double>(k) / pieces);
      path.push_back({p.x(), p.y(), yaw});
    }
  }
  path.push_back({corners.back().x(), corners.back().y(), yaw});
  return path;
}

double lengthOf(const Path2& path) {
  double length = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) length += distance(path[i - 1], path[i]);
  return length;
}

}  // namespace frugal_nav
