#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include <frugal_nav/eval/free_space.hpp>

namespace frugal_nav::eval {

double Solid::distanceTo(const Eigen::Vector2d& p_world) const {
  const Eigen::Vector2d p = world_from_solid.inverse() * p_world;
  if (radius_m > 0.0) return std::max(0.0, p.norm() - radius_m);
  return (p.cwiseAbs() - 0.5 * size_m).cwiseMax(0.0).norm();
}

Polygon2 Solid::outline() const {
  Polygon2 corners;
  if (radius_m > 0.0) {
    constexpr int kCorners = 24;
    for (int i = 0; i < kCorners; ++i) {
      const double angle = 2.0 * M_PI * i / kCorners;
      corners.push_back(world_from_solid *
                        Eigen::Vector2d(radius_m * std::cos(angle), radius_m * std::sin(angle)));
    }
    return corners;
  }
  const Eigen::Vector2d half = 0.5 * size_m;
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(-half.x(), -half.y()), Eigen::Vector2d(half.x(), -half.y()),
        Eigen::Vector2d(half.x(), half.y()), Eigen::Vector2d(-half.x(), half.y())})
    corners.push_back(world_from_solid * corner);
  return corners;
}

FreeSpace::FreeSpace(const Eigen::AlignedBox2d& bounds, const std::vector<Solid>& solids,
                     double disc_radius_m)
    : bounds_(bounds),
      width_(static_cast<int>(std::ceil(bounds.sizes().x() / kCell_m))),
      height_(static_cast<int>(std::ceil(bounds.sizes().y() / kCell_m))),
      free_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 1) {
  for (std::size_t i = 0; i < free_.size(); ++i) {
    const int cell = static_cast<int>(i);
    const Eigen::Vector2d centre =
        bounds_.min() + kCell_m * Eigen::Vector2d(cell % width_ + 0.5, cell / width_ + 0.5);
    free_[i] = std::none_of(solids.begin(), solids.end(), [&](const Solid& solid) {
      return !solid.overhang && solid.distanceTo(centre) < disc_radius_m;
    });
  }
}

int FreeSpace::indexOf(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d cell = (p - bounds_.min()) / kCell_m;
  const int x = static_cast<int>(std::floor(cell.x()));
  const int y = static_cast<int>(std::floor(cell.y()));
  return x < 0 || y < 0 || x >= width_ || y >= height_ ? -1 : y * width_ + x;
}

bool FreeSpace::isFree(const Eigen::Vector2d& p) const {
  const int index = indexOf(p);
  return index >= 0 && free_[static_cast<std::size_t>(index)] != 0;
}

std::optional<double> FreeSpace::pathLength(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  if (!isFree(from) || !isFree(to)) return std::nullopt;
  std::vector<double> length(free_.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  length[static_cast<std::size_t>(indexOf(from))] = 0.0;
  open.push({0.0, indexOf(from)});
  while (!open.empty()) {
    const auto [reached, cell] = open.top();
    open.pop();
    if (cell == indexOf(to)) return reached * kCell_m;
    if (reached > length[static_cast<std::size_t>(cell)]) continue;
    for (int step = 0; step < 9; ++step) {
      const int x = cell % width_ + step % 3 - 1;
      const int y = cell / width_ + step / 3 - 1;
      if (x < 0 || y < 0 || x >= width_ || y >= height_) continue;
      const auto next = static_cast<std::size_t>(y * width_ + x);
      const double candidate = reached + std::hypot(step % 3 - 1, step / 3 - 1);
      if (free_[next] == 0 || candidate >= length[next]) continue;
      length[next] = candidate;
      open.push({candidate, static_cast<int>(next)});
    }
  }
  return std::nullopt;
}

}  // namespace frugal_nav::eval
