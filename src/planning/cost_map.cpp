#include <algorithm>
#include <cmath>

#include <frugal_nav/planning/cost_map.hpp>

namespace frugal_nav {

CostMap::CostMap(const CostMapParams& params, const BodyExtent& body, const RollingGrid& grid,
                 double tight_margin_m)
    : params_(params),
      cell_m_(grid.cell_m()),
      lethal_m_(body.half_width_m + params.lethal_margin_m),
      tight_m_(std::min(body.half_width_m + tight_margin_m, lethal_m_)) {
  validate(params, "cost map");
  if (!(body.half_width_m > 0.0)) throw ConfigError("cost map: the body's half width must be positive");
  const double outer = std::max(lethal_m_, params.inflation_m);
  reach_ = static_cast<int>(std::ceil(outer / cell_m_)) + 1;
  if (reach_ > 150) throw ConfigError("cost map: inflation_m spans more than 150 cells; enlarge cell_m");
  const auto cells = static_cast<std::size_t>(grid.size()) * static_cast<std::size_t>(grid.size());
  states_.resize(cells);
  column_.resize(cells);
  squared_.resize(cells);
  surrounding_.resize(cells);
  weights_.size = grid.size();
  weights_.weights.resize(cells);
  makeTable();
}

void CostMap::makeTable() {
  const double outer = std::max(lethal_m_ + 1e-9, params_.inflation_m);
  for (int squared = 0; squared <= reach_ * reach_; ++squared) {
    const double distance = std::sqrt(squared) * cell_m_;
    if (distance < tight_m_) {
      known_.push_back(WeightGrid::kLethal);
      unknown_.push_back(WeightGrid::kLethal);
      continue;
    }
    if (distance < lethal_m_) {
      known_.push_back(WeightGrid::kHighest);
      unknown_.push_back(WeightGrid::kHighest);
      continue;
    }
    const double nearness = std::max(0.0, (outer - distance) / (outer - lethal_m_));
    const double factor = 1.0 + params_.clearance_weight * nearness * nearness;
    const auto weight = [](double f) {
      return static_cast<std::uint16_t>(
          std::min(std::lround(f * WeightGrid::kFree), long{WeightGrid::kHighest}));
    };
    known_.push_back(weight(factor));
    unknown_.push_back(weight(factor * params_.unknown_weight));
  }
}

void CostMap::read(const RollingGrid& grid) {
  origin_ = grid.origin();
  const int size = weights_.size;
  for (int y = 0; y < size; ++y) {
    grid.copyRow(origin_.y + y, states_.data() + static_cast<std::ptrdiff_t>(y) * size);
  }
}

void CostMap::updateCertain(const RollingGrid& grid, Cell start, int most_doubtful, double from_m) {
  read(grid);
  const auto isCertain = [&](Cell cell) {
    for (int y = cell.y - 1; y <= cell.y + 1; ++y) {
      for (int x = cell.x - 1; x <= cell.x + 1; ++x) {
        if (grid.certainty({x, y}) > most_doubtful) return true;
      }
    }
    return false;
  };
  const double nearest = from_m / cell_m_;
  for (int y = 0; y < weights_.size; ++y) {
    for (int x = 0; x < weights_.size; ++x) {
      const Cell cell{origin_.x + x, origin_.y + y};
      RollingGrid::State& state = states_[weights_.index({x, y})];
      if (state == RollingGrid::State::kOccupied &&
          std::hypot(cell.x - start.x, cell.y - start.y) > nearest && !isCertain(cell))
        state = RollingGrid::State::kUnknown;
    }
  }
  measureClearance();
  weigh(start);
}

void CostMap::update(const RollingGrid& grid, Cell start, double assumed_depth_m) {
  read(grid);
  measureClearance();
  if (assumed_depth_m > 0.0) fillShadows(assumed_depth_m);
  weigh(start);
}

void CostMap::fillShadows(double assumed_depth_m) {
  const double depth = std::min(assumed_depth_m / cell_m_, static_cast<double>(reach_));
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (states_[i] == RollingGrid::State::kUnknown && squared_[i] <= depth * depth)
      states_[i] = RollingGrid::State::kOccupied;
  }
  measureClearance();
}

// The exact Euclidean distance transform, cut off at reach_: along y first, then the best of the neighbouring
// columns. Plain loops over rows, which compilers turn into vector instructions.
void CostMap::measureClearance() {
  const auto size = static_cast<std::size_t>(weights_.size);
  const auto far = static_cast<std::uint16_t>(reach_);
  for (std::size_t i = 0; i < states_.size(); ++i) {
    column_[i] = states_[i] == RollingGrid::State::kOccupied ? std::uint16_t{0} : far;
  }
  const auto lower = [](std::uint16_t& value, std::uint16_t neighbour) {
    value = std::min(value, static_cast<std::uint16_t>(neighbour + 1));
  };
  for (std::size_t i = size; i < column_.size(); ++i) lower(column_[i], column_[i - size]);
  for (std::size_t i = column_.size() - size; i-- > 0;) lower(column_[i], column_[i + size]);
  for (auto& value : column_) value = static_cast<std::uint16_t>(value * value);

  squared_ = column_;
  const int width = weights_.size;
  for (int y = 0; y < width; ++y) {
    const std::uint16_t* source = column_.data() + static_cast<std::ptrdiff_t>(y) * width;
    std::uint16_t* target = squared_.data() + static_cast<std::ptrdiff_t>(y) * width;
    for (int dx = 1; dx < std::min(reach_, width); ++dx) {
      const auto square = static_cast<std::uint16_t>(dx * dx);
      for (int x = 0; x < width - dx; ++x) {
        target[x] = std::min(target[x], static_cast<std::uint16_t>(source[x + dx] + square));
      }
      for (int x = dx; x < width; ++x) {
        target[x] = std::min(target[x], static_cast<std::uint16_t>(source[x - dx] + square));
      }
    }
  }
}

void CostMap::weigh(Cell start) {
  for (std::size_t i = 0; i < states_.size(); ++i) {
    weights_.weights[i] =
        states_[i] == RollingGrid::State::kUnknown ? unknown_[squared_[i]] : known_[squared_[i]];
  }
  relaxAround(toWindow(start));
}

void CostMap::relaxAround(Cell start) {
  if (!weights_.contains(start) || weights_.isPassable(start)) return;
  const std::uint16_t own = squared_[weights_.index(start)];
  const int radius = static_cast<int>(std::ceil(2.0 * lethal_m_ / cell_m_));
  for (int y = start.y - radius; y <= start.y + radius; ++y) {
    for (int x = start.x - radius; x <= start.x + radius; ++x) {
      const Cell cell{x, y};
      const int dx = x - start.x;
      const int dy = y - start.y;
      if (!weights_.contains(cell) || dx * dx + dy * dy > radius * radius) continue;
      std::uint16_t& weight = weights_.weights[weights_.index(cell)];
      if (weight == WeightGrid::kLethal && squared_[weights_.index(cell)] >= own)
        weight = WeightGrid::kHighest;
    }
  }
}

void CostMap::prefer(const Path2& path, double surroundings_m, double surcharge) {
  if (path.empty()) return;
  std::fill(surrounding_.begin(), surrounding_.end(), std::uint8_t{0});
  const int radius = static_cast<int>(std::ceil(surroundings_m / cell_m_));
  const int size = weights_.size;
  for (const Pose2& pose : path) {
    const int cx = static_cast<int>(std::floor(pose.x_m / cell_m_)) - origin_.x;
    const int cy = static_cast<int>(std::floor(pose.y_m / cell_m_)) - origin_.y;
    const int first = std::max(cx - radius, 0);
    const int last = std::min(cx + radius, size - 1);
    if (first > last) continue;
    for (int y = std::max(cy - radius, 0); y <= std::min(cy + radius, size - 1); ++y) {
      const auto row = surrounding_.begin() + static_cast<std::ptrdiff_t>(y) * size;
      std::fill(row + first, row + last + 1, std::uint8_t{1});
    }
  }
  for (std::size_t i = 0; i < surrounding_.size(); ++i) {
    std::uint16_t& weight = weights_.weights[i];
    if (surrounding_[i] != 0 || weight == WeightGrid::kLethal) continue;
    const auto dearer = static_cast<int>(std::lround(weight * (1.0 + surcharge)));
    weight = static_cast<std::uint16_t>(std::min(dearer, WeightGrid::kHighest));
  }
}

void CostMap::block(Cell window_cell, double radius_m) { blockNearer(window_cell, radius_m, HUGE_VAL); }

void CostMap::blockTight(Cell window_cell, double radius_m) { blockNearer(window_cell, radius_m, lethal_m_); }

void CostMap::blockNearer(Cell window_cell, double radius_m, double clearance_m) {
  const int radius = static_cast<int>(std::ceil(radius_m / cell_m_));
  for (int y = window_cell.y - radius; y <= window_cell.y + radius; ++y) {
    for (int x = window_cell.x - radius; x <= window_cell.x + radius; ++x) {
      const int dx = x - window_cell.x;
      const int dy = y - window_cell.y;
      if (!weights_.contains({x, y}) || dx * dx + dy * dy > radius * radius) continue;
      if (this->clearance_m({x, y}) < clearance_m)
        weights_.weights[weights_.index({x, y})] = WeightGrid::kLethal;
    }
  }
}

double CostMap::clearance_m(Cell window_cell) const {
  return std::sqrt(squared_[weights_.index(window_cell)]) * cell_m_;
}

}  // namespace frugal_nav
