#include <algorithm>

#include <frugal_nav/planning/polar_histogram.hpp>

namespace frugal_nav {

PolarHistogram::PolarHistogram(const HistogramParams& params, const HistogramView& view,
                               const std::vector<WindowPoint>& points, const SectorRing* previous)
    : params_(params), binary_(params.sectors), masked_(params.sectors) {
  measure(view, points);
  for (int i = 0; i < params.sectors; ++i) {
    const double density = density_[static_cast<std::size_t>(i)];
    const bool was_free = previous != nullptr && previous->isFree(i);
    const bool is_free = density < params.tau_low || (density <= params.tau_high && was_free);
    if (!is_free) binary_.block(i);
  }
  mask(view, points);
}

void PolarHistogram::measure(const HistogramView& view, const std::vector<WindowPoint>& points) {
  const int sectors = params_.sectors;
  const double width = binary_.width_rad();
  const double b = (params_.nearness - 1.0) / (params_.radius_m * params_.radius_m);
  const double reach = std::min(params_.radius_m, view.within_m);
  // Each cell adds the same to a run of sectors: the runs' ends first, then their sum along the ring.
  std::vector<double> change(static_cast<std::size_t>(sectors) + 1, 0.0);
  const auto addRun = [&](int first, int last, double magnitude) {
    change[static_cast<std::size_t>(first)] += magnitude;
    change[static_cast<std::size_t>(last) + 1] -= magnitude;
  };
  for (const WindowPoint& point : points) {
    const Eigen::Vector2d to = point.p_odom - view.p_odom;
    const double distance2 = to.squaredNorm();
    if (distance2 > reach * reach) continue;
    const double magnitude = point.certainty * point.certainty * (params_.nearness - b * distance2);
    const double half = std::asin(std::min(1.0, view.enlargement_m / std::sqrt(std::max(distance2, 1e-12))));
    const double bearing = std::atan2(to.y(), to.x());
    // The sectors whose centres lie within; where none does, the one that holds the cell.
    int first = static_cast<int>(std::ceil((bearing - half) / width));
    int last = static_cast<int>(std::floor((bearing + half) / width));
    if (first > last) first = last = static_cast<int>(std::lround(bearing / width));
    const int from = ((first % sectors) + sectors) % sectors;
    const int to_sector = from + std::min(last - first, sectors - 1);
    addRun(from, std::min(to_sector, sectors - 1), magnitude);
    if (to_sector >= sectors) addRun(0, to_sector - sectors, magnitude);
  }
  density_.resize(static_cast<std::size_t>(sectors));
  double sum = 0.0;
  for (std::size_t i = 0; i < density_.size(); ++i) density_[i] = std::max(sum += change[i], 0.0);
}

void PolarHistogram::mask(const HistogramView& view, const std::vector<WindowPoint>& points) {
  const double r = view.turning_radius_m;
  double left = M_PI;  // how far around to each side the robot can turn
  double right = M_PI;
  if (r > 0.0) {
    const Pose2 odom_from_robot{view.p_odom.x(), view.p_odom.y(), view.heading_rad};
    const Pose2 robot_from_odom = odom_from_robot.inverse();
    const double near2 = (r + view.enlargement_m) * (r + view.enlargement_m);
    for (const WindowPoint& point : points) {
      const Eigen::Vector2d p = robot_from_odom * point.p_odom;
      const double bearing = std::atan2(p.y(), p.x());
      if (bearing > 0.0 && bearing < left && (p - Eigen::Vector2d(0.0, r)).squaredNorm() < near2)
        left = bearing;
      if (bearing <= 0.0 && -bearing < right && (p + Eigen::Vector2d(0.0, r)).squaredNorm() < near2)
        right = -bearing;
    }
  }
  for (int i = 0; i < params_.sectors; ++i) {
    const double turn = angleBetween(view.heading_rad, binary_.bearingOf(i));
    if (!binary_.isFree(i) || turn > left || -turn > right) masked_.block(i);
  }
}

std::vector<double> PolarHistogram::candidates(double target_rad) const {
  const int sectors = params_.sectors;
  std::vector<double> directions;
  int blocked = 0;
  while (blocked < sectors && masked_.isFree(blocked)) ++blocked;
  if (blocked == sectors) return {target_rad};
  for (int i = 1; i <= sectors;) {
    const auto isFree = [&](int k) { return masked_.isFree((blocked + k) % sectors); };
    int count = 0;
    while (i + count <= sectors && isFree(i + count)) ++count;
    if (count > 0) addValley(blocked + i, count, target_rad, directions);
    i += count + 1;
  }
  return directions;
}

void PolarHistogram::addValley(int first, int count, double target_rad,
                               std::vector<double>& directions) const {
  const double width = masked_.width_rad();
  const double right = first * width;
  const double left = (first + count - 1) * width;
  if (count <= params_.wide_sectors) {
    directions.push_back(wrapAngle(0.5 * (left + right)));
    // A target straight within a narrow valley is no reason to leave its middle; the cost would not.
  } else {
    const double inward = 0.5 * params_.wide_sectors * width;
    directions.push_back(wrapAngle(right + inward));
    directions.push_back(wrapAngle(left - inward));
    const double beyond = angleBetween(right + inward, target_rad);
    const double along = beyond < 0.0 ? beyond + 2.0 * M_PI : beyond;
    if (along <= left - right - 2.0 * inward) directions.push_back(target_rad);
  }
}

}  // namespace frugal_nav
