#include <frugal_nav/perception/dbscan.hpp>

namespace frugal_nav {
namespace {

std::vector<std::size_t> neighbours(const std::vector<Eigen::Vector3d>& points, std::size_t of, double eps) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if ((points[i] - points[of]).squaredNorm() <= eps * eps) found.push_back(i);
  }
  return found;
}

}  // namespace

std::vector<int> dbscan(const std::vector<Eigen::Vector3d>& points, double eps, int min_samples) {
  std::vector<int> labels(points.size(), kNoise);
  std::vector<char> is_expanded(points.size(), 0);
  const auto least = static_cast<std::size_t>(min_samples);
  int cluster = 0;
  for (std::size_t seed = 0; seed < points.size(); ++seed) {
    if (labels[seed] != kNoise) continue;
    std::vector<std::size_t> reached = neighbours(points, seed, eps);
    if (reached.size() < least) continue;
    is_expanded[seed] = 1;
    for (std::size_t next = 0; next < reached.size(); ++next) {
      const std::size_t point = reached[next];
      if (labels[point] == kNoise) labels[point] = cluster;
      if (is_expanded[point] != 0 || labels[point] != cluster) continue;
      is_expanded[point] = 1;
      const std::vector<std::size_t> more = neighbours(points, point, eps);
      if (more.size() < least) continue;
      for (const std::size_t i : more) {
        if (labels[i] == kNoise) reached.push_back(i);
      }
    }
    ++cluster;
  }
  return labels;
}

}  // namespace frugal_nav
