#include <frugal_nav/planning/tight_passage.hpp>

namespace frugal_nav {
namespace {

// The other side lies more than 120 degrees around from the nearest obstacle.
constexpr double kOpposite = -0.5;

}  // namespace

std::optional<TightPassage> passageAt(const Eigen::Vector2d& p_odom,
                                      const std::vector<WindowPoint>& obstacles, double reach_m) {
  const WindowPoint* nearest = nullptr;
  double nearest_m = reach_m;
  for (const WindowPoint& point : obstacles) {
    const double away_m = (point.p_odom - p_odom).norm();
    if (away_m >= nearest_m) continue;
    nearest_m = away_m;
    nearest = &point;
  }
  if (nearest == nullptr || nearest_m < 1e-6) return std::nullopt;
  const Eigen::Vector2d toward = (nearest->p_odom - p_odom) / nearest_m;
  const WindowPoint* opposite = nullptr;
  double opposite_m = reach_m;
  for (const WindowPoint& point : obstacles) {
    const Eigen::Vector2d to = point.p_odom - p_odom;
    if (to.norm() >= opposite_m || to.dot(toward) > kOpposite * to.norm()) continue;
    opposite_m = to.norm();
    opposite = &point;
  }
  if (opposite == nullptr) return std::nullopt;
  const Eigen::Vector2d across = opposite->p_odom - nearest->p_odom;
  const Eigen::Vector2d unit = across.normalized();
  return TightPassage{0.5 * (nearest->p_odom + opposite->p_odom), {-unit.y(), unit.x()}, across.norm()};
}

std::vector<Eigen::Vector2d> leadThrough(const std::vector<Eigen::Vector2d>& line,
                                         const TightPassage& passage, double approach_m) {
  // From where the line first comes as near as the approach to where it last is.
  std::size_t first = line.size();
  std::size_t last = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if ((line[i] - passage.middle_odom).norm() > approach_m) continue;
    first = std::min(first, i);
    last = i;
  }
  if (first == line.size()) return line;
  Eigen::Vector2d along = passage.along_odom;
  const Eigen::Vector2d before = line[first > 0 ? first - 1 : 0];
  const Eigen::Vector2d behind = line[std::min(last + 1, line.size() - 1)];
  if (along.dot(behind - before) < 0.0) along = -along;
  std::vector<Eigen::Vector2d> led(line.begin(), line.begin() + static_cast<std::ptrdiff_t>(first));
  if (first == 0) led.push_back(line.front());
  for (const double s : {-1.0, 0.0, 1.0}) {
    const Eigen::Vector2d p = passage.middle_odom + s * approach_m * along;
    // What lies behind an end that is within the approach is left out.
    const bool skipped = (first == 0 && along.dot(p - line.front()) <= 0.0) ||
                         (last + 1 == line.size() && along.dot(line.back() - p) <= 0.0);
    if (!skipped) led.push_back(p);
  }
  if (last + 1 == line.size()) led.push_back(line.back());
  led.insert(led.end(), line.begin() + static_cast<std::ptrdiff_t>(last) + 1, line.end());
  return led;
}

}  // namespace frugal_nav
