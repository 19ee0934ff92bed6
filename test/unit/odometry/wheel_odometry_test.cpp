#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <frugal_nav/odometry/wheel_odometry.hpp>

namespace frugal_nav {
namespace {

constexpr WheelGeometry kGeometry{0.033, 0.21};
constexpr double kPeriod_s = 0.02;

/// Perfect wheels that count whole ticks.
class Wheels {
 public:
  explicit Wheels(int ticks_per_revolution = 1440) : per_revolution_(ticks_per_revolution) {}
  void roll(const Twist2& twist, double duration_s) {
    const double half = 0.5 * kGeometry.separation_m * twist.w_radps;
    left_rad += (twist.v_mps - half) * duration_s / kGeometry.radius_m;
    right_rad += (twist.v_mps + half) * duration_s / kGeometry.radius_m;
  }
  std::int64_t left() const { return ticks(left_rad); }
  std::int64_t right() const { return ticks(right_rad); }
  double left_rad = 0.0;
  double right_rad = 0.0;

 private:
  std::int64_t ticks(double angle_rad) const {
    return static_cast<std::int64_t>(std::floor(angle_rad / (2.0 * M_PI) * per_revolution_));
  }
  int per_revolution_;
};

/// Odometry fed by perfect wheels at 50 Hz.
struct Drive {
  explicit Drive(const WheelOdometryParams& params = {}) : odometry(params, kGeometry) { read(); }
  void read() {
    const auto result = odometry.addTicks(stamp, offset + wheels.left(), offset + wheels.right());
    if (result) last = *result;
  }
  void hold(const Twist2& twist, double duration_s) {
    const int steps = static_cast<int>(std::lround(duration_s / kPeriod_s));
    for (int i = 0; i < steps; ++i) {
      wheels.roll(twist, duration_s / steps);
      stamp += fromSeconds(kPeriod_s);
      read();
    }
  }
  Wheels wheels;
  WheelOdometry odometry;
  Stamp stamp = stampFromSeconds(10.0);
  std::int64_t offset = 0;
  Odometry last;
};

TEST(WheelOdometry, StartsAtItsStartingPose) {
  WheelOdometryParams params;
  params.start_x_m = 1.0;
  params.start_y_m = -2.0;
  params.start_yaw_rad = 0.5;
  WheelOdometry odometry(params, kGeometry);
  const auto first = odometry.addTicks(stampFromSeconds(3.0), 12345, -777);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->stamp, stampFromSeconds(3.0));
  EXPECT_DOUBLE_EQ(first->odom_from_base.x_m, 1.0);
  EXPECT_DOUBLE_EQ(first->odom_from_base.y_m, -2.0);
  EXPECT_DOUBLE_EQ(first->odom_from_base.yaw_rad, 0.5);
  EXPECT_TRUE(first->twist.isZero());
}

TEST(WheelOdometry, FollowsTheExactArc) {
  WheelOdometry odometry({}, kGeometry);
  odometry.addAngles(stampFromSeconds(0.0), 0.0, 0.0);
  Wheels wheels;
  wheels.roll({0.5, 1.2},
              1.0);  // one single step: a chain of short straight ones would be off by centimetres
  const auto end = odometry.addAngles(stampFromSeconds(1.0), wheels.left_rad, wheels.right_rad);
  ASSERT_TRUE(end);
  const Pose2 truth = arcMotion({0.5, 1.2}, 1.0);
  EXPECT_NEAR(end->odom_from_base.x_m, truth.x_m, 1e-12);
  EXPECT_NEAR(end->odom_from_base.y_m, truth.y_m, 1e-12);
  EXPECT_NEAR(end->odom_from_base.yaw_rad, truth.yaw_rad, 1e-12);
}

// 16 m of path and four turns from ticks alone: the quantisation, at most one tick (0.14 mm) a wheel, turns
// the robot by 1.4e-4 / 0.21 = 0.7 mrad at most, so it is off by less than 3 mm after a 4 m side: 0.02 % of
// the path.
class WheelOdometrySquare : public testing::TestWithParam<double> {};

TEST_P(WheelOdometrySquare, ClosesWithin0_2PercentOfThePath) {
  Drive drive;
  for (int side = 0; side < 4; ++side) {
    drive.hold({0.4, 0.0}, 10.0);
    drive.hold({0.0, GetParam() * M_PI / 2.0}, 1.0);
  }
  const double error_m = drive.last.odom_from_base.position().norm();
  RecordProperty("error_pct", std::to_string(100.0 * error_m / 16.0));
  EXPECT_LT(error_m, 0.002 * 16.0);
  EXPECT_LT(std::abs(drive.last.odom_from_base.yaw_rad), 0.002);
}
INSTANTIATE_TEST_SUITE_P(BothWays, WheelOdometrySquare, testing::Values(1.0, -1.0));

class WheelOdometryBits : public testing::TestWithParam<int> {};

TEST_P(WheelOdometryBits, SurvivesTickRollOver) {
  const int bits = GetParam();
  WheelOdometryParams params;
  params.tick_bits = bits;
  WheelOdometry odometry(params, kGeometry);
  // As a counter of that width gives it, both signed and unsigned, 300 counts around the roll-over; 64 bits
  // too.
  const std::uint64_t mask =
      bits == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << static_cast<unsigned>(bits)) - 1;
  const std::uint64_t top = mask / 2;  // the largest signed count
  std::optional<Odometry> last;
  for (std::uint64_t i = 0; i <= 30; ++i) {
    const std::uint64_t unsigned_count = (mask - 150 + 10 * i) & mask;
    const std::uint64_t raw = (top - 150 + 10 * i) & mask;
    const std::int64_t signed_count =
        raw > top ? static_cast<std::int64_t>(raw | ~mask) : static_cast<std::int64_t>(raw);
    last = odometry.addTicks(stampFromSeconds(0.02 * static_cast<double>(i)),
                             static_cast<std::int64_t>(unsigned_count), signed_count);
    ASSERT_TRUE(last);
  }
  EXPECT_NEAR(last->odom_from_base.x_m, 300.0 / 1440.0 * 2.0 * M_PI * 0.033, 1e-9);
  EXPECT_NEAR(last->odom_from_base.yaw_rad, 0.0, 1e-12);
  EXPECT_EQ(odometry.counts().rebased, 0U);
}
INSTANTIATE_TEST_SUITE_P(Widths, WheelOdometryBits, testing::Values(16, 32, 64));

TEST(WheelOdometry, SurvivesARestartedCounter) {
  Drive drive;
  drive.offset = 500000;
  drive.odometry.restart({});
  drive.read();
  drive.hold({0.3, 0.0}, 2.0);
  const double before_m = drive.last.odom_from_base.x_m;
  const double sure = drive.last.pose_covariance.trace();
  drive.offset = -drive.wheels.left();  // the board has rebooted: it counts from zero again
  drive.hold({0.3, 0.0}, kPeriod_s);
  EXPECT_DOUBLE_EQ(drive.last.odom_from_base.x_m, before_m);
  EXPECT_NEAR(drive.last.twist.v_mps, 0.3, 0.01) << "the robot has not stopped because its counter has";
  EXPECT_GT(drive.last.pose_covariance.trace(), sure);
  EXPECT_EQ(drive.odometry.counts().rebased, 1U);
  drive.hold({0.3, 0.0}, 1.0);
  EXPECT_NEAR(drive.last.odom_from_base.x_m, before_m + 0.3, 3e-4);  // two ticks
  EXPECT_NEAR(drive.last.twist.v_mps, 0.3, 0.005);
}

TEST(WheelOdometry, ARestartDuringALongGapIsNoMotion) {
  Drive drive;
  drive.read();
  drive.hold({0.3, 0.0}, 7.0);  // 2.1 m, which a wheel could roll in the second of the gap
  const double before_m = drive.last.odom_from_base.x_m;
  drive.stamp += fromSeconds(1.0);
  drive.offset = -drive.wheels.left();  // the board was reset meanwhile
  drive.read();
  EXPECT_DOUBLE_EQ(drive.last.odom_from_base.x_m, before_m);
  EXPECT_EQ(drive.odometry.counts().rebased, 1U);
}

TEST(WheelOdometry, MotionDuringAGapCounts) {
  WheelOdometry odometry(WheelOdometryParams{}, kGeometry);
  odometry.addTicks(stampFromSeconds(0.0), 0, 0);
  const auto after = odometry.addTicks(stampFromSeconds(2.0), 4860, 4860);  // 0.35 m/s
  ASSERT_TRUE(after);
  EXPECT_EQ(odometry.counts().rebased, 0U);
  EXPECT_NEAR(after->odom_from_base.x_m, 0.7, 0.01);
}

TEST(WheelOdometry, RebasesWhenAGapHidesHowOftenACounterRolledOver) {
  WheelOdometryParams params;
  params.tick_bits = 16;  // half of its range is 4.7 m: less than 2.5 m/s may roll in 3 s
  WheelOdometry odometry(params, kGeometry);
  odometry.addTicks(stampFromSeconds(0.0), 0, 0);
  const auto after = odometry.addTicks(stampFromSeconds(3.0), 1000, 1000);
  ASSERT_TRUE(after);
  EXPECT_EQ(odometry.counts().rebased, 1U);
  EXPECT_EQ(after->odom_from_base.x_m, 0.0);
}

TEST(WheelOdometry, RollingVelocityFollowsAChange) {
  Drive drive;
  drive.hold({0.3, -0.4}, 1.0);
  // One tick of 0.144 mm at each end of a window of 0.1 s: 1.4 mm/s, and 14 mrad/s over 0.21 m.
  EXPECT_NEAR(drive.last.twist.v_mps, 0.3, 0.0015);
  EXPECT_NEAR(drive.last.twist.w_radps, -0.4, 0.014);
  drive.hold({0.0, 0.0}, 0.12);
  EXPECT_NEAR(drive.last.twist.v_mps, 0.0, 1e-12);
  EXPECT_NEAR(drive.last.twist.w_radps, 0.0, 1e-12);
}

TEST(WheelOdometry, CovarianceGrowsWithMotionAndNeverWhileStanding) {
  Drive drive;
  double last_trace = 0.0;
  for (int i = 0; i < 5; ++i) {
    drive.hold({0.2, 0.3}, 1.0);
    EXPECT_GT(drive.last.pose_covariance.trace(), last_trace);
    last_trace = drive.last.pose_covariance.trace();
    const Eigen::Matrix3d driven = drive.last.pose_covariance;
    drive.hold({0.0, 0.0}, 1.0);
    EXPECT_EQ(drive.last.pose_covariance, driven);
  }
}

// On a straight line of length d both wheels vary by k d each: v along by k d / 2, yaw by 2 k d / b^2, and
// sideways by the integral of yaw, 2 k / b^2 * d^3 / 3 (the continuous random walk; 50 steps a second come
// within 2 %).
TEST(WheelOdometry, CovarianceOfAStraightLineIsTheAnalyticOne) {
  WheelOdometryParams params;
  params.distance_noise_m = 1e-4;
  Drive drive(params);
  drive.hold({0.5, 0.0}, 4.0);
  const double k = 1e-4, d = 2.0, b = 0.21;
  const Eigen::Matrix3d& c = drive.last.pose_covariance;
  EXPECT_NEAR(c(0, 0), k * d / 2.0, 0.02 * k * d / 2.0);
  EXPECT_NEAR(c(2, 2), 2.0 * k * d / (b * b), 0.02 * 2.0 * k * d / (b * b));
  EXPECT_NEAR(c(1, 1), 2.0 * k / (b * b) * d * d * d / 3.0, 0.02 * 2.0 * k / (b * b) * d * d * d / 3.0);
  EXPECT_NEAR(c(1, 2), k * d * d / (b * b), 0.02 * k * d * d / (b * b));
  EXPECT_EQ(c, c.transpose());
}

TEST(WheelOdometry, ArcDerivativesAreTheNumericOnes) {
  constexpr double kStep = 1e-6;
  for (const double left : {0.0, 0.03, -0.05, 0.2}) {
    for (const double right : {0.03, 0.0300001, 0.2, -0.1}) {
      const double yaw = 0.7;
      const ArcStep step = arcStep(yaw, left, right, 0.21);
      const auto end = [&](double l, double r, double y) {
        const Pose2 pose = Pose2{0.0, 0.0, y} * arcStep(y, l, r, 0.21).motion;
        return Eigen::Vector3d(pose.x_m, pose.y_m, y + arcStep(y, l, r, 0.21).motion.yaw_rad);
      };
      const Eigen::Vector3d by_left =
          (end(left + kStep, right, yaw) - end(left - kStep, right, yaw)) / (2 * kStep);
      const Eigen::Vector3d by_right =
          (end(left, right + kStep, yaw) - end(left, right - kStep, yaw)) / (2 * kStep);
      const Eigen::Vector3d by_yaw =
          (end(left, right, yaw + kStep) - end(left, right, yaw - kStep)) / (2 * kStep);
      // Central differences: h^2 times a third derivative of order 1, and rounding 1e-16 / h.
      EXPECT_LT((step.by_wheel.col(0) - by_left).norm(), 1e-8) << left << ' ' << right;
      EXPECT_LT((step.by_wheel.col(1) - by_right).norm(), 1e-8) << left << ' ' << right;
      EXPECT_LT((step.by_pose.col(2) - by_yaw).norm(), 1e-8) << left << ' ' << right;
    }
  }
}

TEST(WheelOdometry, CalibrationMultipliersScaleTheMotion) {
  WheelOdometryParams params;
  params.left_radius_multiplier = 1.1;
  params.right_radius_multiplier = 0.9;
  params.separation_multiplier = 2.0;
  WheelOdometry odometry(params, kGeometry);
  odometry.addAngles(stampFromSeconds(0.0), 0.0, 0.0);
  const auto end = odometry.addAngles(stampFromSeconds(1.0), 1.0, 1.0);
  ASSERT_TRUE(end);
  EXPECT_NEAR(end->twist.v_mps, 0.033, 1e-12);
  EXPECT_NEAR(end->odom_from_base.yaw_rad, 0.033 * (0.9 - 1.1) / 0.42, 1e-12);
}

TEST(WheelOdometry, ADuplicateStampGivesNothing) {
  WheelOdometry odometry({}, kGeometry);
  odometry.addTicks(stampFromSeconds(1.0), 0, 0);
  EXPECT_FALSE(odometry.addTicks(stampFromSeconds(1.0), 50, 50));
  EXPECT_EQ(odometry.counts().duplicates, 1U);
  const auto next = odometry.addTicks(stampFromSeconds(1.02), 50, 50);
  ASSERT_TRUE(next);
  EXPECT_GT(next->odom_from_base.x_m, 0.0) << "the duplicate's counts must not have become the base";
}

TEST(WheelOdometry, ABackwardStampStartsAgain) {
  WheelOdometryParams params;
  params.start_x_m = 5.0;
  Drive drive(params);
  drive.hold({0.3, 0.2}, 2.0);
  const auto again = drive.odometry.addTicks(stampFromSeconds(1.0), 42, 42);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->stamp, stampFromSeconds(1.0));
  EXPECT_EQ(again->odom_from_base.x_m, 5.0);
  EXPECT_EQ(again->odom_from_base.yaw_rad, 0.0);
  EXPECT_EQ(again->pose_covariance, Eigen::Matrix3d::Zero().eval());
  EXPECT_TRUE(again->twist.isZero());
  EXPECT_EQ(drive.odometry.counts().restarts, 1U);
}

TEST(WheelOdometry, RefusesAnglesThatAreNotFinite) {
  WheelOdometry odometry({}, kGeometry);
  odometry.addAngles(stampFromSeconds(0.0), 0.0, 0.0);
  EXPECT_FALSE(odometry.addAngles(stampFromSeconds(0.1), std::nan(""), 0.0));
  EXPECT_FALSE(odometry.addAngles(stampFromSeconds(0.1), 0.0, std::numeric_limits<double>::infinity()));
  EXPECT_EQ(odometry.counts().refused, 2U);
  EXPECT_TRUE(odometry.addAngles(stampFromSeconds(0.1), 0.1, 0.1))
      << "a refused reading leaves nothing behind";
}

TEST(WheelOdometry, WheelAnglesAreCumulative) {
  Drive drive;
  drive.hold({0.3, 0.0}, 1.0);
  EXPECT_NEAR(drive.odometry.leftAngle_rad(), 0.3 / 0.033, 2.0 * M_PI / 1440.0);
  EXPECT_NEAR(drive.odometry.rightAngle_rad(), 0.3 / 0.033, 2.0 * M_PI / 1440.0);
}

TEST(WheelOdometry, RefusesBadConfiguration) {
  EXPECT_THROW(WheelOdometry({}, {0.0, 0.2}), ConfigError);
  EXPECT_THROW(WheelOdometry({}, {0.03, std::nan("")}), ConfigError);
  WheelOdometryParams params;
  params.tick_bits = 24;
  try {
    WheelOdometry odometry(params, kGeometry);
    FAIL() << "24 bits were taken";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("tick_bits"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace frugal_nav
