#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/planning/lidar_avoidance.hpp>
#include <frugal_nav/planning/lidar_planner.hpp>

namespace frugal_nav {
namespace {

constexpr BodyExtent kBody{0.125, 0.203};
constexpr int kScans = 200;

/// A drive through an 8 m x 6 m room with fourteen posts: each scan with the pose it was taken at.
struct Drive {
  std::vector<LaserScan> scans;
  std::vector<Odometry> odometry;
};

double rangeTo(const Eigen::Vector2d& post, double radius_m, const Pose2& from, double angle_rad) {
  const Eigen::Vector2d d(std::cos(angle_rad), std::sin(angle_rad));
  const Eigen::Vector2d to = post - from.position();
  const double along = to.dot(d);
  const double aside2 = to.squaredNorm() - along * along;
  if (along < 0.0 || aside2 > radius_m * radius_m) return std::numeric_limits<double>::infinity();
  return along - std::sqrt(radius_m * radius_m - aside2);
}

double rangeToWalls(const Pose2& from, double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  const double x = ((c > 0.0 ? 8.0 : 0.0) - from.x_m) / c;
  const double y = ((s > 0.0 ? 3.0 : -3.0) - from.y_m) / s;
  return std::min(std::abs(c) < 1e-9 ? y : x, std::abs(s) < 1e-9 ? x : y);
}

Drive makeDrive() {
  Random random(600001);
  std::vector<Eigen::Vector2d> posts;
  for (int i = 0; i < 14; ++i) posts.emplace_back(random.uniform(1.5, 7.0), random.uniform(-2.6, 2.6));
  Drive drive;
  for (int k = 0; k < kScans; ++k) {
    LaserScan scan;
    scan.stamp = stampFromSeconds(0.1 * k);
    scan.angle_min_rad = -M_PI;
    scan.angle_increment_rad = 2.0 * M_PI / 360.0;
    scan.range_min_m = 0.15;
    scan.range_max_m = 12.0;
    Odometry odometry;
    odometry.stamp = scan.stamp;
    odometry.odom_from_base = {0.5 + 0.001 * k, 0.4 * std::sin(0.05 * k), 0.3 * std::sin(0.05 * k)};
    for (std::size_t i = 0; i < 360; ++i) {
      const double angle = odometry.odom_from_base.yaw_rad + scan.angleOf(i);
      double range = rangeToWalls(odometry.odom_from_base, angle);
      for (const auto& post : posts)
        range = std::min(range, rangeTo(post, 0.25, odometry.odom_from_base, angle));
      scan.ranges_m.push_back(static_cast<float>(range * (1.0 + random.normal(0.01))));
    }
    drive.scans.push_back(scan);
    drive.odometry.push_back(odometry);
  }
  return drive;
}

void runPlanner(benchmark::State& state, const LidarPlannerParams& params) {
  const Drive drive = makeDrive();
  LidarPlanner planner(params, kBody);
  planner.setGoal(Pose2{7.5, 1.0, 0.0});
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(planner.update(drive.scans[k], {}, drive.odometry[k].odom_from_base));
    k = (k + 1) % kScans;
  }
}

void lidarPlannerUpdate(benchmark::State& state) { runPlanner(state, {}); }
BENCHMARK(lidarPlannerUpdate)->Unit(benchmark::kMicrosecond);

/// The dearest case: no way is wide enough, so that all that can be reached is searched.
void lidarPlannerNoWay(benchmark::State& state) {
  LidarPlannerParams wide;
  wide.cost.lethal_margin_m = 0.4;
  runPlanner(state, wide);
}
BENCHMARK(lidarPlannerNoWay)->Unit(benchmark::kMicrosecond);

/// Resident memory of this process [MB].
double residentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0.0;
  double resident_pages = 0.0;
  statm >> pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// The value that 95 of a hundred are not above.
double percentile95(std::vector<double> values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Processor time of this thread: what others do on the machine does not count.
double threadMicroseconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e6 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_nsec);
}

/// A scan in, a command out: the grid, A* and a method of lidar_avoidance. Beside the mean it reports the
/// 95th percentile and by how much the process has grown since before its first planner.
void runCycle(benchmark::State& state, const std::string& method) {
  const Drive drive = makeDrive();
  static const double before_mb = residentMegabytes();
  LidarAvoidanceParams params;
  params.method = method;
  LidarAvoidance avoidance(params, kBody);
  LidarPlanner planner(LidarPlannerParams{}, kBody);
  const Pose2 goal{7.5, 1.0, 0.0};
  planner.setGoal(goal);
  avoidance.setGoal(goal);
  std::vector<double> times_us;
  std::size_t k = 0;
  for (auto _ : state) {
    const double start_us = threadMicroseconds();
    const LidarPlan plan = planner.update(drive.scans[k], {}, drive.odometry[k].odom_from_base);
    avoidance.setPath(plan.stamp, plan.path);
    benchmark::DoNotOptimize(avoidance.update(drive.scans[k], {}, drive.odometry[k]));
    times_us.push_back(threadMicroseconds() - start_us);
    k = (k + 1) % kScans;
  }
  state.counters["p95_us"] = percentile95(times_us);
  state.counters["grown_MB"] = residentMegabytes() - before_mb;
}

void lidarCycleVfhStar(benchmark::State& state) { runCycle(state, "vfh_star"); }
BENCHMARK(lidarCycleVfhStar)->Unit(benchmark::kMicrosecond);

void lidarCycleVfhPlus(benchmark::State& state) { runCycle(state, "vfh_plus"); }
BENCHMARK(lidarCycleVfhPlus)->Unit(benchmark::kMicrosecond);

void lidarCycleDynamicWindow(benchmark::State& state) { runCycle(state, "dwa"); }
BENCHMARK(lidarCycleDynamicWindow)->Unit(benchmark::kMicrosecond);

void lidarAvoidanceUpdate(benchmark::State& state) {
  const Drive drive = makeDrive();
  LidarAvoidance avoidance(LidarAvoidanceParams{}, kBody);
  LidarPlanner planner(LidarPlannerParams{}, kBody);
  const Pose2 goal{7.5, 1.0, 0.0};
  planner.setGoal(goal);
  avoidance.setGoal(goal);
  const LidarPlan plan = planner.update(drive.scans[0], {}, drive.odometry[0].odom_from_base);
  std::size_t k = 0;
  for (auto _ : state) {
    avoidance.setPath(drive.scans[k].stamp, plan.path);
    benchmark::DoNotOptimize(avoidance.update(drive.scans[k], {}, drive.odometry[k]));
    k = (k + 1) % kScans;
  }
}
BENCHMARK(lidarAvoidanceUpdate)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace frugal_nav
