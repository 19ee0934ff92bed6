#include <algorithm>
#include <cmath>
#include <limits>

#include <frugal_nav/planning/rolling_grid.hpp>

namespace frugal_nav {
namespace {

constexpr int kMostCells =
    1000;  // along a side; four million cells are eight megabytes and too slow to search

int wrapIndex(int index, int size) {
  const int rest = index % size;
  return rest < 0 ? rest + size : rest;
}

}  // namespace

std::string RollingGridParams::check() const {
  if (window_m / cell_m > kMostCells) return "window_m / cell_m is above 1000 cells";
  if (window_m / cell_m < 10.0) return "window_m / cell_m is below 10 cells";
  return {};
}

RollingGrid::RollingGrid(const RollingGridParams& params)
    : params_(params), size_(2 * static_cast<int>(std::lround(params.window_m / params.cell_m / 2.0))) {
  validate(params, "rolling grid");
  origin_ = {-size_ / 2, -size_ / 2};
  entries_.resize(static_cast<std::size_t>(size_) * static_cast<std::size_t>(size_));
  memory_ms_ = static_cast<std::uint32_t>(params.memory_s * 1e3);
}

void RollingGrid::setParams(const RollingGridParams& params) {
  if (params.window_m != params_.window_m || params.cell_m != params_.cell_m) {
    *this = RollingGrid(params);
    return;
  }
  validate(params, "rolling grid");
  params_ = params;
  memory_ms_ = static_cast<std::uint32_t>(params.memory_s * 1e3);
  for (Entry& entry : entries_) {
    entry.certainty =
        static_cast<std::int8_t>(std::min(static_cast<int>(entry.certainty), params.max_certainty));
  }
}

void RollingGrid::reset() {
  std::fill(entries_.begin(), entries_.end(), Entry{});
  started_ = false;
  now_ms_ = 0;
}

void RollingGrid::moveTo(const Eigen::Vector2d& p_odom) {
  const Cell center = cellOf(p_odom);
  const Cell target{center.x - size_ / 2, center.y - size_ / 2};
  const int dx = std::clamp(target.x - origin_.x, -size_, size_);
  const int dy = std::clamp(target.y - origin_.y, -size_, size_);
  forgetColumns(dx > 0 ? target.x + size_ - dx : target.x, std::abs(dx));
  forgetRows(dy > 0 ? target.y + size_ - dy : target.y, std::abs(dy));
  origin_ = target;
}

bool RollingGrid::holds(const Pose2& pose) {
  constexpr double kFarthest_m = 1e6;
  return pose.isFinite() && std::abs(pose.x_m) < kFarthest_m && std::abs(pose.y_m) < kFarthest_m;
}

void RollingGrid::forgetColumns(int first_x, int count) {
  for (int i = 0; i < count; ++i) {
    const int column = wrapIndex(first_x + i, size_);
    for (int row = 0; row < size_; ++row) entries_[static_cast<std::size_t>(row * size_ + column)] = Entry{};
  }
}

void RollingGrid::forgetRows(int first_y, int count) {
  for (int i = 0; i < count; ++i) {
    const auto row = entries_.begin() + static_cast<std::ptrdiff_t>(wrapIndex(first_y + i, size_)) * size_;
    std::fill(row, row + size_, Entry{});
  }
}

void RollingGrid::begin(Stamp stamp) {
  if (!started_) {
    started_ = true;
    epoch_ = stamp;
  }
  const double age_ms = toSeconds(stamp - epoch_) * 1e3;
  now_ms_ = std::max(now_ms_, static_cast<std::uint32_t>(std::max(age_ms, 0.0)));
  ++scan_number_;
}

void RollingGrid::insert(const LaserScan& scan, const Pose2& odom_from_laser) {
  begin(scan.stamp);
  const auto end_of_ray = [&](std::size_t beam, double range_m) {
    const double angle = scan.angleOf(beam);
    return odom_from_laser * Eigen::Vector2d(range_m * std::cos(angle), range_m * std::sin(angle));
  };
  // Marks come first: a cell that any ray of this scan hits is not cleared by its neighbours.
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range = scan.ranges_m[i];
    const Return kind = classify(scan, scan.ranges_m[i]);
    if (kind == Return::kHit && range <= params_.max_range_m) mark(end_of_ray(i, range));
    if (kind == Return::kTooClose) mark(end_of_ray(i, scan.range_min_m));
  }
  const double longest = std::min(params_.max_range_m, scan.range_max_m);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const Return kind = classify(scan, scan.ranges_m[i]);
    if (kind != Return::kHit && kind != Return::kFree) continue;
    const double range = kind == Return::kHit ? static_cast<double>(scan.ranges_m[i]) : longest;
    const bool ends_free = kind == Return::kFree || range > longest;
    clear(odom_from_laser.position(), end_of_ray(i, std::min(range, longest)), ends_free);
  }
}

void RollingGrid::touch(Entry& entry) {
  entry.seen = true;
  entry.scan = scan_number_;
  entry.last_seen_ms = now_ms_;
}

void RollingGrid::mark(const Eigen::Vector2d& p_odom) {
  const Cell cell = cellOf(p_odom);
  if (!contains(cell)) return;
  Entry& hit = entry(cell);
  if (hit.seen && hit.scan == scan_number_) return;
  const int before = isForgotten(hit) ? 0 : static_cast<int>(hit.certainty);
  hit.certainty = static_cast<std::int8_t>(std::min(before + params_.hit_gain, params_.max_certainty));
  touch(hit);
}

// Amanatides and Woo (1987): every cell the segment passes, in order.
void RollingGrid::clear(const Eigen::Vector2d& from_odom, const Eigen::Vector2d& to_odom, bool include_end) {
  visitRay(from_odom, to_odom, include_end, [this](Entry& passed) {
    const int before = isForgotten(passed) ? 0 : static_cast<int>(passed.certainty);
    passed.certainty = static_cast<std::int8_t>(std::max(before - params_.miss_loss, 0));
    touch(passed);
  });
}

void RollingGrid::clearDoubtful(const Eigen::Vector2d& from_odom, const Eigen::Vector2d& to_odom,
                                int most_certain) {
  visitRay(from_odom, to_odom, false, [&](Entry& passed) {
    const int before = isForgotten(passed) ? 0 : static_cast<int>(passed.certainty);
    if (before > most_certain) return;
    passed.certainty = static_cast<std::int8_t>(std::max(before - params_.miss_loss, 0));
    touch(passed);
  });
}

template <class Visit>
void RollingGrid::visitRay(const Eigen::Vector2d& from_odom, const Eigen::Vector2d& to_odom, bool include_end,
                           const Visit& visit) {
  Cell cell = cellOf(from_odom);
  const Cell last = cellOf(to_odom);
  const Eigen::Vector2d step = to_odom - from_odom;
  const auto axis = [this](double start, double length, int index, int& direction, double& next,
                           double& delta) {
    direction = length > 0.0 ? 1 : -1;
    if (length == 0.0) {
      next = delta = std::numeric_limits<double>::infinity();
      return;
    }
    const double border = (index + (length > 0.0 ? 1 : 0)) * params_.cell_m;
    next = (border - start) / length;
    delta = params_.cell_m / std::abs(length);
  };
  int step_x = 0, step_y = 0;
  double next_x = 0.0, next_y = 0.0, delta_x = 0.0, delta_y = 0.0;
  axis(from_odom.x(), step.x(), cell.x, step_x, next_x, delta_x);
  axis(from_odom.y(), step.y(), cell.y, step_y, next_y, delta_y);
  const int cells = std::abs(last.x - cell.x) + std::abs(last.y - cell.y) + (include_end ? 1 : 0);
  for (int i = 0; i < cells && contains(cell); ++i) {
    Entry& passed = entry(cell);
    if (!passed.seen || passed.scan != scan_number_) visit(passed);
    if (next_x < next_y) {
      next_x += delta_x;
      cell.x += step_x;
    } else {
      next_y += delta_y;
      cell.y += step_y;
    }
  }
}

void RollingGrid::erase(const Eigen::Vector2d& p_odom, double radius_m, int most_certain) {
  const Cell center = cellOf(p_odom);
  const int reach = static_cast<int>(std::ceil(radius_m / params_.cell_m));
  for (int y = center.y - reach; y <= center.y + reach; ++y) {
    for (int x = center.x - reach; x <= center.x + reach; ++x) {
      if (!contains({x, y}) || (centerOf({x, y}) - p_odom).norm() > radius_m) continue;
      Entry& gone = entry({x, y});
      if (stateOf(gone) != State::kOccupied || gone.certainty > most_certain) continue;
      gone.certainty = 0;
      touch(gone);
    }
  }
}

bool RollingGrid::isForgotten(const Entry& entry) const {
  return !entry.seen || now_ms_ - entry.last_seen_ms > memory_ms_;
}

RollingGrid::State RollingGrid::stateOf(const Entry& entry) const {
  if (isForgotten(entry)) return State::kUnknown;
  return entry.certainty > 0 ? State::kOccupied : State::kFree;
}

RollingGrid::State RollingGrid::state(Cell cell) const {
  return contains(cell) ? stateOf(entry(cell)) : State::kUnknown;
}

int RollingGrid::certainty(Cell cell) const {
  if (!contains(cell) || isForgotten(entry(cell))) return 0;
  return entry(cell).certainty;
}

void RollingGrid::copyRow(int y, State* row) const {
  const std::size_t first = static_cast<std::size_t>(wrapIndex(y, size_)) * static_cast<std::size_t>(size_);
  int column = wrapIndex(origin_.x, size_);
  for (int i = 0; i < size_; ++i) {
    row[i] = stateOf(entries_[first + static_cast<std::size_t>(column)]);
    if (++column == size_) column = 0;
  }
}

int RollingGrid::ringIndex(Cell cell) const {
  return wrapIndex(cell.y, size_) * size_ + wrapIndex(cell.x, size_);
}

bool RollingGrid::contains(Cell cell) const {
  return cell.x >= origin_.x && cell.x < origin_.x + size_ && cell.y >= origin_.y &&
         cell.y < origin_.y + size_;
}

Cell RollingGrid::cellOf(const Eigen::Vector2d& p_odom) const {
  return {static_cast<int>(std::floor(p_odom.x() / params_.cell_m)),
          static_cast<int>(std::floor(p_odom.y() / params_.cell_m))};
}

Eigen::Vector2d RollingGrid::centerOf(Cell cell) const {
  return {(cell.x + 0.5) * params_.cell_m, (cell.y + 0.5) * params_.cell_m};
}

}  // namespace frugal_nav
