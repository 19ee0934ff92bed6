#include "flat_world.hpp"

#include <gtest/gtest.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/planning/vfh_star.hpp>

namespace frugal_nav {
namespace {

using planning_test::FlatWorld;
using planning_test::kBody;

constexpr double kSector_rad = 5.0 / 180.0 * M_PI;

/// Certain obstacles at places in odom.
std::vector<WindowPoint> certain(const std::vector<Eigen::Vector2d>& places) {
  std::vector<WindowPoint> points;
  for (const Eigen::Vector2d& p : places) points.push_back({p, 1.0});
  return points;
}

HistogramView viewFrom(const Eigen::Vector2d& p_odom, double enlargement_m) {
  HistogramView view;
  view.p_odom = p_odom;
  view.enlargement_m = enlargement_m;
  return view;
}

TEST(PolarHistogram, AnObstacleBlocksTheAngleThatItsEnlargementSubtends) {
  // asin(0.5 / 1) = 30 degrees to each side: sectors -6 .. 6 of 5 degrees around its bearing.
  const PolarHistogram histogram({}, viewFrom({0.0, 0.0}, 0.5), certain({{0.0, 1.0}}), nullptr);
  const SectorRing& ring = histogram.binary();
  const int center = ring.sectorOf(M_PI / 2);
  for (int i = 0; i < ring.size(); ++i) {
    const double off = std::abs(angleBetween(ring.bearingOf(center), ring.bearingOf(i)));
    EXPECT_EQ(ring.isFree(i), off > M_PI / 6 + 1e-6) << ring.bearingOf(i);
  }
}

TEST(PolarHistogram, MagnitudeGrowsWithCertaintyAndNearness) {
  // m = c^2 (a - b d^2) with a = 4 and a - b R^2 = 1 at the window's radius R = 1.5 m: b = 4 / 3 per m^2.
  const HistogramParams params;
  const auto density = [&](double certainty, double distance_m) {
    const std::vector<WindowPoint> points{{{distance_m, 0.0}, certainty}};
    return PolarHistogram(params, viewFrom({0.0, 0.0}, 0.2), points, nullptr).density().front();
  };
  EXPECT_NEAR(density(1.0, 1.5), 1.0, 1e-9);
  EXPECT_NEAR(density(1.0, 0.75), 4.0 - 4.0 / 3.0 * 0.5625, 1e-9);
  EXPECT_NEAR(density(0.5, 0.75), 0.25 * density(1.0, 0.75), 1e-9);
  EXPECT_EQ(density(1.0, 1.6), 0.0) << "beyond the window";
}

TEST(PolarHistogram, BetweenTheThresholdsASectorStaysAsItWas) {
  HistogramParams params;
  params.tau_low = 0.25;
  params.tau_high = 0.5;
  const std::vector<WindowPoint> doubtful{{{1.5, 0.0}, std::sqrt(0.4)}};
  SectorRing was_free(params.sectors);
  SectorRing was_blocked(params.sectors);
  was_blocked.block(0);
  const HistogramView view = viewFrom({0.0, 0.0}, 0.2);
  EXPECT_TRUE(PolarHistogram(params, view, doubtful, &was_free).binary().isFree(0));
  EXPECT_FALSE(PolarHistogram(params, view, doubtful, &was_blocked).binary().isFree(0));
}

TEST(PolarHistogram, AnObstacleOnTheTurningCircleBlocksThatSideFromItsBearingOutward) {
  // Ahead to the left, at 45 degrees: the circle of 1 m to the left about (0, 1) passes it within 0.3 m.
  HistogramView view = viewFrom({0.0, 0.0}, 0.2);
  const auto points = certain({{0.75, 0.75}});
  const auto isFree = [&](double bearing_rad) {
    const PolarHistogram histogram({}, view, points, nullptr);
    return histogram.masked().isFree(histogram.masked().sectorOf(bearing_rad));
  };
  EXPECT_TRUE(isFree(M_PI / 2)) << "it can turn on the spot";
  view.turning_radius_m = 1.0;
  EXPECT_FALSE(isFree(M_PI / 2));
  EXPECT_TRUE(isFree(0.0));
  EXPECT_TRUE(isFree(-M_PI / 2)) << "the other side stays open";
}

TEST(PolarHistogram, CandidatesAreTheMiddleOfANarrowValleyAndTheSidesOfAWideOne) {
  // A ring of obstacles with one gap: between 60 and 120 degrees before enlargement.
  std::vector<Eigen::Vector2d> places;
  for (int i = 0; i <= 300; ++i) {
    const double bearing = 120.0 + i;
    places.emplace_back(std::cos(bearing / 180.0 * M_PI), std::sin(bearing / 180.0 * M_PI));
  }
  const auto candidates = [&](double enlargement_m, double target_rad) {
    return PolarHistogram({}, viewFrom({0.0, 0.0}, enlargement_m), certain(places), nullptr)
        .candidates(target_rad);
  };
  const std::vector<double> narrow = candidates(0.2, M_PI);
  ASSERT_EQ(narrow.size(), 1U);
  EXPECT_NEAR(narrow.front(), M_PI / 2, kSector_rad / 2 + 1e-9);
  EXPECT_TRUE(candidates(0.6, M_PI).empty());
  const std::vector<double> open =
      PolarHistogram({}, viewFrom({0.0, 0.0}, 0.2), certain({{1.0, 0.0}}), nullptr).candidates(M_PI);
  // Blocked are 11.5 degrees to each side, sectors -2 .. 2; the sides lie 8 sectors inside the valley.
  ASSERT_EQ(open.size(), 3U);
  EXPECT_NEAR(open[0], 11 * kSector_rad, 1e-9);
  EXPECT_NEAR(open[1], -11 * kSector_rad, 1e-9);
  EXPECT_NEAR(open[2], M_PI, 1e-9);
}

/// A robot without inertia driven through a flat world by one method.
template <class Method>
class VfhDrive {
 public:
  explicit VfhDrive(FlatWorld world) : world_(std::move(world)) {}

  /// Drives for a time; the least distance of base_link to a wall is kept.
  void run(const Eigen::Vector2d& target, double duration_s) {
    for (double t = 0.0; t < duration_s && (target - pose.position()).norm() > 0.1; t += 0.1) {
      Odometry odometry;
      odometry.stamp = stampFromSeconds(1.0 + t);
      odometry.odom_from_base = pose;
      odometry.twist = twist_;
      const LaserScan scan = world_.scan(pose, 1.0 + t);
      window_.update(scan, pose, pose.position());
      const std::vector<Eigen::Vector2d> obstacles = obstaclePoints(scan, {});
      const MotionCommand command = method_.plan({scan, {}, obstacles, odometry, target, target, &window_});
      twist_ = command.holds == MotionCommand::Holds::kVelocity ? command.velocity : Twist2{};
      pose = pose * arcMotion(twist_, 0.1);
      least_m = std::min(least_m, world_.clearance(pose.position()));
    }
  }

  Pose2 pose;
  double least_m = HUGE_VAL;

 private:
  FlatWorld world_;
  Twist2 twist_;
  ActiveWindow window_{RollingGridParams{}};
  Method method_{VfhParams{}, SpeedParams{}, kBody};
};

FlatWorld roomWithABox() { return FlatWorld().box(-2.0, -3.0, 6.0, 3.0).box(1.2, -0.4, 1.6, 0.5); }

TEST(VfhPlus, DrivesAroundABoxWithTheSafetyDistance) {
  VfhDrive<VfhPlus> drive(roomWithABox());
  drive.run({3.0, 0.0}, 40.0);
  EXPECT_LT((drive.pose.position() - Eigen::Vector2d(3.0, 0.0)).norm(), 0.12);
  EXPECT_GT(drive.least_m, kBody.half_width_m + VfhParams{}.least_safety_m);
}

TEST(VfhPlus, GoesThroughADoorNarrowerThanItsSafetyDistances) {
  // 0.30 m: the body's 0.25 m and 2.5 cm to each side, where 8 cm are wanted.
  VfhDrive<VfhPlus> drive(
      FlatWorld().box(-2.0, -2.0, 4.0, 2.0).wall(1.0, -2.0, 1.0, -0.15).wall(1.0, 0.15, 1.0, 2.0));
  drive.run({2.5, 0.0}, 60.0);
  EXPECT_LT((drive.pose.position() - Eigen::Vector2d(2.5, 0.0)).norm(), 0.12);
  EXPECT_GT(drive.least_m, kBody.half_width_m);
}

TEST(VfhPlus, TurnsWhereNothingIsFreeAndThenSaysSo) {
  const FlatWorld closet = FlatWorld().box(-0.25, -0.25, 0.25, 0.25);
  VfhPlus method({}, {}, kBody);
  ActiveWindow window{RollingGridParams{}};
  Odometry odometry;
  MotionCommand command;
  for (double t = 1.0; t < 6.0; t += 0.1) {
    const LaserScan scan = closet.scan({}, t);
    window.update(scan, {}, {0.0, 0.0});
    const std::vector<Eigen::Vector2d> obstacles = obstaclePoints(scan, {});
    command = method.plan({scan, {}, obstacles, odometry, {2.0, 0.0}, {2.0, 0.0}, &window});
    EXPECT_EQ(command.velocity.v_mps, 0.0);
  }
  EXPECT_EQ(command.status, MotionCommand::Status::kBlocked);
}

/// A pocket that opens toward the robot, its mouth nearer to the target's direction than the way around it.
FlatWorld pocket() {
  return FlatWorld()
      .box(-2.0, -3.0, 6.0, 3.0)
      .wall(0.8, 0.45, 2.2, 0.45)
      .wall(2.2, 0.45, 2.2, -0.4)
      .wall(2.2, -0.4, 0.8, -0.4);
}

TEST(VfhStar, SeesThatAPocketIsADeadEndBeforeItDrivesIn) {
  VfhDrive<VfhStar> looking(pocket());
  looking.run({3.5, 0.0}, 60.0);
  EXPECT_LT((looking.pose.position() - Eigen::Vector2d(3.5, 0.0)).norm(), 0.12);
}

}  // namespace
}  // namespace frugal_nav
