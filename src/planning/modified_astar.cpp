#include <algorithm>
#include <array>
#include <limits>
#include <queue>
#include <utility>

#include <frugal_nav/planning/modified_astar.hpp>

namespace frugal_nav {
namespace {

constexpr std::array<Cell, 8> kSteps{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
constexpr double kFarthest_m = 100.0;  // a goal farther away would make a grid that fills the memory
// A straight line's cost is sampled, the run's is summed over its cells: they differ by rounding.
constexpr double kTolerance = 1.02;

bool isNear(const Eigen::Vector2d& p, const Eigen::Vector2d& robot) {
  return p.allFinite() && (p - robot).norm() < kFarthest_m;
}

/// Cells within a radius of a cell, nearest first.
std::vector<Cell> disc(Cell center, double radius_cells) {
  const int reach = static_cast<int>(std::floor(radius_cells));
  std::vector<std::pair<int, Cell>> found;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      if (x * x + y * y <= radius_cells * radius_cells)
        found.push_back({x * x + y * y, {center.x + x, center.y + y}});
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Cell> cells;
  for (const auto& entry : found) cells.push_back(entry.second);
  return cells;
}

}  // namespace

ModifiedAStar::ModifiedAStar(const ModifiedAStarParams& params) : params_(params) {
  validate(params, "modified A*");
}

void ModifiedAStar::setParams(const ModifiedAStarParams& params) {
  validate(params, "modified A*");
  params_ = params;
}

void ModifiedAStar::startMission(const Eigen::Vector2d& start, const Eigen::Vector2d& goal) {
  start_ = start;
  h0_m_ = std::max((goal - start).norm(), params_.cell_m);
  moveGoal(goal);
}

void ModifiedAStar::moveGoal(const Eigen::Vector2d& goal) {
  goal_ = goal;
  const Eigen::Vector2d way = start_ ? Eigen::Vector2d(goal - *start_) : Eigen::Vector2d::UnitY();
  if (way.norm() > 1e-6) vertical_ = way.normalized();
}

double ModifiedAStar::horizontalFactor(const Eigen::Vector2d& p_odom) const {
  return 1.0 + params_.kappa * (goal_ - p_odom).norm() / h0_m_;
}

ModifiedAStar::Result ModifiedAStar::plan(const Query& query, const Cost& cost) {
  Result none;
  expanded_ = 0;
  if (!start_ || !query.robot.allFinite() || !isNear(query.goal, query.robot)) {
    none.status = Result::Status::kBadInput;
    return none;
  }
  layGrid(query);
  const Cell start{0, 0};
  const Cell goal = cellOf(query.goal);
  const std::optional<Cell> target = freeCellNear(goal, query.goal_tolerance_m, cost);
  if (!target) {
    none.status = Result::Status::kGoalBlocked;
    return none;
  }
  const bool has_gap = query.gap && isNear(*query.gap, query.robot) && contains(cellOf(*query.gap)) &&
                       std::isfinite(costAt(cellOf(*query.gap), cost));
  if (params_.mode == "literal" && has_gap) {
    const Cell gap = cellOf(*query.gap);
    if (!search(start, *target, gap, cost)) return none;
    const std::vector<Cell> cells = trace(*target);
    Result result = resultOf(cells, nodes_[indexOf(*target)].cost);
    result.through_gap = std::find(cells.begin(), cells.end(), gap) != cells.end();
    result.reaches_goal = *target == goal;
    return result;
  }
  Result direct = route(start, *target, goal, query, cost);
  if (!has_gap || direct.status != Result::Status::kFound) return direct;

  const Cell gap = cellOf(*query.gap);
  if (!search(start, gap, std::nullopt, cost)) return direct;
  Result through = resultOf(trace(gap), nodes_[indexOf(gap)].cost);
  if (!search(gap, *target, std::nullopt, cost)) return direct;
  const Result rest = resultOf(trace(*target), nodes_[indexOf(*target)].cost);
  if (through.length_m + rest.length_m > (1.0 + params_.eta) * direct.length_m) return direct;
  through.points.insert(through.points.end(), rest.points.begin() + 1, rest.points.end());
  through.cost += rest.cost;
  through.length_m += rest.length_m;
  through.through_gap = true;
  through.reaches_goal = *target == goal;
  return through;
}

ModifiedAStar::Result ModifiedAStar::route(Cell start, Cell target, Cell goal, const Query& query,
                                           const Cost& cost) {
  Result result;
  std::optional<Cell> end = target;
  if (!search(start, target, std::nullopt, cost)) end = closedCellNear(goal, query.goal_tolerance_m);
  if (!end) return result;
  result = resultOf(trace(*end), nodes_[indexOf(*end)].cost);
  result.reaches_goal = *end == goal;
  return result;
}

void ModifiedAStar::layGrid(const Query& query) {
  robot_ = query.robot;
  const int margin = static_cast<int>(std::ceil(params_.detour_m / params_.cell_m));
  const Cell goal = cellOf(query.goal);
  Cell low{std::min(0, goal.x), std::min(0, goal.y)};
  Cell high{std::max(0, goal.x), std::max(0, goal.y)};
  if (query.gap && isNear(*query.gap, query.robot)) {
    const Cell gap = cellOf(*query.gap);
    low = {std::min(low.x, gap.x), std::min(low.y, gap.y)};
    high = {std::max(high.x, gap.x), std::max(high.y, gap.y)};
  }
  lowest_ = {low.x - margin, low.y - margin};
  width_ = high.x - low.x + 2 * margin + 1;
  height_ = high.y - low.y + 2 * margin + 1;
  costs_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), -1.0);
}

Cell ModifiedAStar::cellOf(const Eigen::Vector2d& p_odom) const {
  const Eigen::Vector2d p = p_odom - robot_;
  const Eigen::Vector2d right(vertical_.y(), -vertical_.x());
  return {static_cast<int>(std::lround(p.dot(right) / params_.cell_m)),
          static_cast<int>(std::lround(p.dot(vertical_) / params_.cell_m))};
}

Eigen::Vector2d ModifiedAStar::placeOf(Cell cell) const {
  const Eigen::Vector2d right(vertical_.y(), -vertical_.x());
  return robot_ + params_.cell_m * (cell.x * right + cell.y * vertical_);
}

bool ModifiedAStar::contains(Cell cell) const {
  return cell.x >= lowest_.x && cell.y >= lowest_.y && cell.x < lowest_.x + width_ &&
         cell.y < lowest_.y + height_;
}

std::size_t ModifiedAStar::indexOf(Cell cell) const {
  return static_cast<std::size_t>(cell.y - lowest_.y) * static_cast<std::size_t>(width_) +
         static_cast<std::size_t>(cell.x - lowest_.x);
}

double ModifiedAStar::costAt(Cell cell, const Cost& cost) {
  if (!contains(cell)) return std::numeric_limits<double>::infinity();
  double& known = costs_[indexOf(cell)];
  if (known < 0.0) known = std::max(cost(placeOf(cell)), 1.0);
  return known;
}

std::optional<Cell> ModifiedAStar::freeCellNear(Cell cell, double tolerance_m, const Cost& cost) {
  for (const Cell near : disc(cell, tolerance_m / params_.cell_m)) {
    if (std::isfinite(costAt(near, cost))) return near;
  }
  return std::nullopt;
}

std::optional<Cell> ModifiedAStar::closedCellNear(Cell cell, double tolerance_m) const {
  for (const Cell near : disc(cell, tolerance_m / params_.cell_m)) {
    if (contains(near) && nodes_[indexOf(near)].closed) return near;
  }
  return std::nullopt;
}

double ModifiedAStar::anisotropicLength(const Eigen::Vector2d& step, double m_h) const {
  const double along = step.dot(vertical_);
  const double across_squared = std::max(step.squaredNorm() - along * along, 0.0);
  return std::sqrt(along * along + m_h * m_h * across_squared);
}

/// From a cell to another; entering `costless` erases the cost so far (paper 000, algorithm 3). The straight
/// distance is a consistent estimate, since every step costs its length or more; only the erased cost breaks
/// that, and nodes already closed then stay as they are.
bool ModifiedAStar::search(Cell start, Cell goal, const std::optional<Cell>& costless, const Cost& cost) {
  struct Entry {
    double estimate;
    std::size_t index;
    bool operator>(const Entry& other) const {
      return estimate != other.estimate ? estimate > other.estimate : index > other.index;
    }
  };
  nodes_.assign(costs_.size(), Node{});
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> waiting;
  const auto remaining = [&](Cell cell) {
    return params_.cell_m * std::hypot(goal.x - cell.x, goal.y - cell.y);
  };
  nodes_[indexOf(start)].open = true;
  waiting.push({remaining(start), indexOf(start)});
  while (!waiting.empty()) {
    const std::size_t index = waiting.top().index;
    waiting.pop();
    if (nodes_[index].closed) continue;
    nodes_[index].closed = true;
    ++expanded_;
    const Cell cell{lowest_.x + static_cast<int>(index % static_cast<std::size_t>(width_)),
                    lowest_.y + static_cast<int>(index / static_cast<std::size_t>(width_))};
    if (cell == goal) return true;
    const double m_h = horizontalFactor(placeOf(cell));
    for (const Cell step : kSteps) {
      const Cell next{cell.x + step.x, cell.y + step.y};
      const double place = costAt(next, cost);
      if (!std::isfinite(place)) continue;
      const bool diagonal = step.x != 0 && step.y != 0;
      if (diagonal &&
          !(std::isfinite(costAt({next.x, cell.y}, cost)) && std::isfinite(costAt({cell.x, next.y}, cost))))
        continue;
      Node& node = nodes_[indexOf(next)];
      if (node.closed) continue;
      const double step_cost = diagonal ? std::sqrt(1.0 + m_h * m_h) : step.x != 0 ? m_h : 1.0;
      double through = nodes_[index].cost + params_.cell_m * step_cost * place;
      if (costless && next == *costless) through = 0.0;
      if (node.open && node.cost <= through) continue;
      node.open = true;
      node.cost = through;
      node.parent = static_cast<std::int32_t>(index);
      waiting.push({through + remaining(next), indexOf(next)});
    }
  }
  return false;
}

std::vector<Cell> ModifiedAStar::trace(Cell end) const {
  std::vector<Cell> cells;
  for (auto index = static_cast<std::int32_t>(indexOf(end)); index >= 0;
       index = nodes_[static_cast<std::size_t>(index)].parent) {
    cells.push_back({lowest_.x + index % width_, lowest_.y + index / width_});
  }
  std::reverse(cells.begin(), cells.end());
  return cells;
}

ModifiedAStar::Result ModifiedAStar::resultOf(const std::vector<Cell>& cells, double cost) const {
  Result result;
  result.status = Result::Status::kFound;
  result.cost = cost;
  for (const Cell cell : cells) result.points.push_back(placeOf(cell));
  for (std::size_t i = 1; i < result.points.size(); ++i)
    result.length_m += (result.points[i] - result.points[i - 1]).norm();
  return result;
}

double ModifiedAStar::lineCost(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                               const Cost& cost) const {
  const Eigen::Vector2d way = to - from;
  const int pieces = std::max(1, static_cast<int>(std::ceil(2.0 * way.norm() / params_.cell_m)));
  double sum = 0.0;
  for (int i = 1; i <= pieces; ++i) {
    const Eigen::Vector2d left = from + way * (static_cast<double>(i - 1) / pieces);
    sum += anisotropicLength(way / pieces, horizontalFactor(left)) * cost(left + way / pieces);
    if (!std::isfinite(sum)) break;
  }
  return sum;
}

std::vector<Eigen::Vector2d> ModifiedAStar::straighten(const std::vector<Eigen::Vector2d>& points,
                                                       const Cost& cost) const {
  if (points.size() < 3) return points;
  std::vector<Eigen::Vector2d> corners{points.front()};
  std::size_t from = 0;
  while (from + 1 < points.size()) {
    std::size_t to = from + 1;
    double run = lineCost(points[from], points[to], cost);
    while (to + 1 < points.size()) {
      run += lineCost(points[to], points[to + 1], cost);
      if (lineCost(points[from], points[to + 1], cost) > kTolerance * run) break;
      ++to;
    }
    corners.push_back(points[to]);
    from = to;
  }
  return corners;
}

}  // namespace frugal_nav
