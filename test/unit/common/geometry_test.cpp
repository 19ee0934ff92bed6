#include <gtest/gtest.h>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/random.hpp>

namespace frugal_nav {
namespace {

constexpr double kRounding = 1e-12;  // a few operations on numbers of order 10

TEST(WrapAngle, KeepsTheHalfOpenInterval) {
  EXPECT_EQ(wrapAngle(M_PI), M_PI);
  EXPECT_EQ(wrapAngle(-M_PI), M_PI);
  EXPECT_NEAR(wrapAngle(3.0 * M_PI), M_PI, kRounding);
  EXPECT_NEAR(wrapAngle(-3.0 * M_PI), M_PI, kRounding);
  EXPECT_NEAR(wrapAngle(M_PI + 1e-6), -M_PI + 1e-6, kRounding);
  EXPECT_NEAR(wrapAngle(-M_PI - 1e-6), M_PI - 1e-6, kRounding);
  EXPECT_EQ(wrapAngle(0.0), 0.0);
  Random random(500001);
  for (int i = 0; i < 1000; ++i) {
    const double angle = random.uniform(-100.0, 100.0);
    const double wrapped = wrapAngle(angle);
    EXPECT_GT(wrapped, -M_PI);
    EXPECT_LE(wrapped, M_PI);
    EXPECT_NEAR(std::cos(wrapped), std::cos(angle), kRounding);
    EXPECT_NEAR(std::sin(wrapped), std::sin(angle), kRounding);
  }
}

TEST(AngleBetween, TurnsTheShortWay) {
  EXPECT_NEAR(angleBetween(3.0, -3.0), 2.0 * M_PI - 6.0, kRounding);
  EXPECT_NEAR(angleBetween(-3.0, 3.0), 6.0 - 2.0 * M_PI, kRounding);
}

Pose2 randomPose(Random& random) {
  return {random.uniform(-10, 10), random.uniform(-10, 10), random.uniform(-M_PI, M_PI)};
}

TEST(Pose2, TimesItsInverseIsIdentity) {
  Random random(500002);
  for (int i = 0; i < 1000; ++i) {
    const Pose2 a_from_b = randomPose(random);
    for (const Pose2& identity : {a_from_b * a_from_b.inverse(), a_from_b.inverse() * a_from_b}) {
      EXPECT_NEAR(identity.x_m, 0.0, kRounding);
      EXPECT_NEAR(identity.y_m, 0.0, kRounding);
      EXPECT_NEAR(wrapAngle(identity.yaw_rad), 0.0, kRounding);
    }
  }
}

TEST(Pose2, ComposesAsItsPointsDo) {
  Random random(500003);
  for (int i = 0; i < 1000; ++i) {
    const Pose2 a_from_b = randomPose(random);
    const Pose2 b_from_c = randomPose(random);
    const Eigen::Vector2d p_c(random.uniform(-5, 5), random.uniform(-5, 5));
    EXPECT_LT(((a_from_b * b_from_c) * p_c - a_from_b * (b_from_c * p_c)).norm(), 10 * kRounding);
  }
}

TEST(Pose2, KnowsWhetherItIsFinite) {
  EXPECT_TRUE(Pose2{}.isFinite());
  EXPECT_FALSE((Pose2{0.0, NAN, 0.0}).isFinite());
  EXPECT_FALSE((Pose2{0.0, 0.0, INFINITY}).isFinite());
}

TEST(BearingTo, IsPositiveToTheLeft) {
  EXPECT_NEAR(bearingTo({1.0, 1.0, M_PI / 2}, {0.0, 1.0}), M_PI / 2, kRounding);
  EXPECT_NEAR(bearingTo({1.0, 1.0, M_PI / 2}, {2.0, 1.0}), -M_PI / 2, kRounding);
}

/// Midpoint integration in n steps: its error falls with 1/n^2.
Pose2 integrate(const Twist2& twist, double duration_s, int steps) {
  Pose2 pose;
  const double dt = duration_s / steps;
  for (int i = 0; i < steps; ++i) {
    const double heading = twist.w_radps * (i + 0.5) * dt;
    pose.x_m += twist.v_mps * dt * std::cos(heading);
    pose.y_m += twist.v_mps * dt * std::sin(heading);
  }
  pose.yaw_rad = wrapAngle(twist.w_radps * duration_s);
  return pose;
}

TEST(ArcMotion, EqualsNumericIntegration) {
  Random random(500004);
  for (int i = 0; i < 100; ++i) {
    const Twist2 twist{random.uniform(-1, 1), random.uniform(-3, 3)};
    const double duration = random.uniform(0.0, 3.0);
    const Pose2 exact = arcMotion(twist, duration);
    const Pose2 numeric = integrate(twist, duration, 20000);
    // length * (w dt)^2 / 24 with at most 3 m and 9 rad in 20,000 steps: 3e-8 m
    EXPECT_NEAR(exact.x_m, numeric.x_m, 3e-8);
    EXPECT_NEAR(exact.y_m, numeric.y_m, 3e-8);
    EXPECT_NEAR(angleBetween(exact.yaw_rad, numeric.yaw_rad), 0.0, kRounding);
  }
}

TEST(ArcMotion, IsSmoothWhereTheArcBecomesALine) {
  for (const double w : {0.0, 1e-300, 1e-12, 9.9e-7, 1.1e-6, -1.1e-6, 1e-5}) {
    const Pose2 motion = arcMotion({1.0, w}, 1.0);
    EXPECT_NEAR(motion.x_m, 1.0 - w * w / 6.0, 1e-11) << w;
    // (1 - cos w) / w loses digits near zero: one rounding, 1e-16, over 1e-6.
    EXPECT_NEAR(motion.y_m, w / 2.0, 2e-10) << w;
  }
}

TEST(ArcMotion, TurnsOnTheSpotWithoutMoving) {
  const Pose2 motion = arcMotion({0.0, 1.0}, M_PI / 2);
  EXPECT_EQ(motion.x_m, 0.0);
  EXPECT_EQ(motion.y_m, 0.0);
  EXPECT_NEAR(motion.yaw_rad, M_PI / 2, kRounding);
}

TEST(Interpolate, TurnsTheShortWayAcrossPi) {
  const Pose2 middle = interpolate({0, 0, 3.0}, {2, 4, -3.0}, 0.5);
  EXPECT_NEAR(middle.x_m, 1.0, kRounding);
  EXPECT_NEAR(middle.y_m, 2.0, kRounding);
  EXPECT_NEAR(std::abs(middle.yaw_rad), M_PI, kRounding);
}

}  // namespace
}  // namespace frugal_nav
