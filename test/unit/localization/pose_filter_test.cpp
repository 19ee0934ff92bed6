#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/localization/pose_filter.hpp>

namespace frugal_nav {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Stamp at(double seconds) { return stampFromSeconds(100.0 + seconds); }

PoseFix fixAt(const Pose2& pose, double sigma = 0.02) {
  PoseFix fix;
  fix.map_from_base = pose;
  fix.covariance = Eigen::Vector3d(sigma * sigma, sigma * sigma, sigma * sigma).asDiagonal();
  return fix;
}

LandmarkSighting sightingOf(const Eigen::Vector2d& p_map, double range_m, double bearing_rad) {
  LandmarkSighting sighting;
  sighting.p_map = p_map;
  sighting.range_m = range_m;
  sighting.bearing_rad = bearing_rad;
  sighting.covariance.diagonal() << 0.01, 0.001;
  return sighting;
}

/// Encoders at 50 Hz and gyro at 100 Hz of a steady twist, from one time to another [s].
void drive(PoseFilter& filter, double from_s, double to_s, const Twist2& twist, double gyro_bias = 0.0) {
  const int last = static_cast<int>(std::lround(100.0 * to_s));
  for (int i = static_cast<int>(std::lround(100.0 * from_s)); i <= last; ++i) {
    const Stamp now = at(0.01 * i);
    if (i % 2 == 0) filter.addEncoders(now, twist, now);
    filter.addGyro(now, twist.w_radps + gyro_bias, now);
  }
}

TEST(PoseFilter, TellsNothingBeforeTheFirstFix) {
  PoseFilter filter{PoseFilterParams{}};
  EXPECT_FALSE(filter.estimate());
  drive(filter, 0.0, 1.0, {0.3, 0.0});
  EXPECT_EQ(filter.addSighting(at(1.0), sightingOf({2.0, 0.0}, 2.0, 0.0), at(1.0)), FilterStatus::kNoFix);
  EXPECT_FALSE(filter.estimate());
  EXPECT_FALSE(filter.estimateAt(at(1.0)));
  EXPECT_EQ(filter.addPose(at(1.0), fixAt({5.0, 6.0, 1.0}), at(1.0)), FilterStatus::kUsed);
  ASSERT_TRUE(filter.estimate());
  EXPECT_NEAR(filter.estimate()->map_from_base.x_m, 5.0, 1e-12);
  EXPECT_NEAR(filter.estimate()->covariance(0, 0), 0.02 * 0.02, 1e-12);
  EXPECT_FALSE(filter.estimateAt(at(0.9)));
}

TEST(PoseFilter, FollowsWheelsAndGyro) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({0.0, 0.0, 0.0}), at(0.0));
  drive(filter, 0.0, 2.0, {0.5, M_PI_4});
  const Pose2 expected = arcMotion({0.5, M_PI_4}, 2.0);
  const PoseEstimate estimate = *filter.estimate();
  EXPECT_NEAR(estimate.map_from_base.x_m, expected.x_m, 1e-9);
  EXPECT_NEAR(estimate.map_from_base.y_m, expected.y_m, 1e-9);
  EXPECT_NEAR(estimate.map_from_base.yaw_rad, M_PI_2, 1e-9);
  EXPECT_EQ(estimate.source, MotionSource::kTwistAndGyro);
}

/// Wheels at 50 Hz and gyro at 100 Hz of a robot that speeds up by `growth` (of v and w) a second from rest.
PoseEstimate spedUp(double growth, bool has_gyro) {
  PoseFilterParams params;
  params.still_speed_mps = params.still_rate_radps = 0.0;  // the first steps are slow
  PoseFilter filter{params};
  filter.addPose(at(0.0), fixAt({0.0, 0.0, 0.0}), at(0.0));
  for (int i = 0; i <= 100; ++i) {
    const double time_s = 0.01 * i;
    const double mean = i == 0 ? 0.0 : growth * (time_s - 0.01);  // of the last 0.02 s
    if (has_gyro) filter.addGyro(at(time_s), growth * time_s, at(time_s));
    if (i % 2 == 0) filter.addEncoders(at(time_s), {mean, mean}, at(time_s));
  }
  return *filter.estimate();
}

TEST(PoseFilter, ChangingRatesTurnByTheirMeans) {
  // A rate that grows evenly turns by half its end times the time; taken to hold between readings of 100 Hz
  // it would be 0.005 rad less, between those of 50 Hz twice that. Either order of gyro and wheels at a
  // stamp.
  EXPECT_NEAR(spedUp(1.0, true).map_from_base.yaw_rad, 0.5, 1e-9);
  EXPECT_NEAR(spedUp(1.0, false).map_from_base.yaw_rad, 0.5, 1e-9);
}

TEST(PoseFilter, ChangingSpeedsMoveByTheirMeans) {
  // Speed and rate grow alike, along a circle of 1 m: 0.1 m of it. Taken to hold it would be 2 mm less; the
  // heading between the wheels' readings adds 1e-5 m.
  const Pose2 pose = spedUp(0.2, true).map_from_base;
  EXPECT_NEAR(pose.x_m, std::sin(0.1), 1e-5);
  EXPECT_NEAR(pose.y_m, 1.0 - std::cos(0.1), 1e-5);
}

TEST(PoseFilter, ASuddenStopMovesNoFarther) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({0.0, 0.0, 0.0}), at(0.0));
  drive(filter, 0.0, 1.0, {0.2, 0.0});
  drive(filter, 1.02, 2.0, {0.0, 0.0});
  EXPECT_NEAR(filter.estimate()->map_from_base.x_m, 0.2, 1e-9);  // held on, it would be 4 mm more
}

TEST(PoseFilter, LearnsTheGyrosBiasWhileTheWheelsStand) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({0.0, 0.0, 0.0}), at(0.0));
  drive(filter, 0.0, 5.0, {0.0, 0.0}, 0.03);
  // 4.7 s of a gyro of 0.0005 rad/sqrt(s) leave 0.0005 / sqrt(4.7) = 0.0002 rad/s and a ten thousandth of the
  // prior.
  EXPECT_NEAR(filter.estimate()->gyro_bias_radps, 0.03, 1e-4);
  // The body turned by the bias only until the wheels were believed to stand: 0.3 s.
  EXPECT_LT(std::abs(filter.estimate()->map_from_base.yaw_rad), 0.03 * 0.35);
}

TEST(PoseFilter, ATurnWithStandingWheelsIsNoBias) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({0.0, 0.0, 0.0}), at(0.0));
  for (int i = 0; i <= 100; ++i) {
    if (i % 2 == 0) filter.addEncoders(at(0.01 * i), {0.0, 0.0}, at(0.01 * i));
    filter.addGyro(at(0.01 * i), 0.5, at(0.01 * i));  // someone turns the robot
  }
  EXPECT_NEAR(filter.estimate()->map_from_base.yaw_rad, 0.5, 1e-9);
  EXPECT_EQ(filter.estimate()->gyro_bias_radps, 0.0);
}

TEST(PoseFilter, PosesTeachTheBiasWhileDriving) {
  PoseFilter filter{PoseFilterParams{}};
  for (int second = 0; second < 20; ++second) {
    filter.addPose(at(second), fixAt(arcMotion({0.3, 0.2}, second)), at(second));
    drive(filter, second, second + 0.99, {0.3, 0.2}, 0.02);
  }
  // Headings of 0.02 rad over 20 s: 0.02 * sqrt(12) / (20 * sqrt(20)) = 0.0008 rad/s.
  EXPECT_NEAR(filter.estimate()->gyro_bias_radps, 0.02, 0.0025);
}

TEST(PoseFilter, SightingsTeachScaleAndRateBias) {
  PoseFilterParams params;
  params.estimate_scale = params.estimate_rate_bias = true;
  PoseFilter filter{params};
  Pose2 truth;
  filter.addPose(at(0.0), fixAt(truth), at(0.0));
  for (int i = 0; i <= 3000; ++i) {
    const Stamp now = at(0.02 * i);
    filter.addEncoders(now, {0.3, 0.21}, now);  // rolls 10 % farther than told, turns 0.01 rad/s slower
    if (i > 0) truth = truth * arcMotion({0.33, 0.20}, 0.02);
    for (const Eigen::Vector2d& p : {Eigen::Vector2d(4.0, 1.0), Eigen::Vector2d(-3.0, 3.0)}) {
      if (i % 10 == 0)
        filter.addSighting(now, sightingOf(p, (p - truth.position()).norm(), bearingTo(truth, p)), now);
    }
  }
  EXPECT_NEAR(filter.estimate()->scale, 1.1, 0.01);
  EXPECT_NEAR(filter.estimate()->rate_bias_radps, 0.01, 0.003);
  EXPECT_LT(distance(filter.estimate()->map_from_base, truth), 0.02);
}

/// What one arrival hands to the filter.
struct Arrival {
  double received_s = 0.0;
  std::function<FilterStatus(PoseFilter&)> hand_over;
};

/// A drive with noisy poses and sightings, among them two that the gate refuses, in the order of arrival.
std::vector<Arrival> recordedDrive(double delay_s) {
  std::vector<Arrival> arrivals;
  Random random(500001);
  for (int i = 0; i <= 300; ++i) {
    const double t = 0.01 * i;
    const Pose2 truth = arcMotion({0.4, 0.3}, t);
    if (i % 2 == 0) {
      const Twist2 twist{0.4 + random.normal(0.02), 0.3};
      arrivals.push_back({t, [=](PoseFilter& f) { return f.addEncoders(at(t), twist, at(t)); }});
    }
    const double rate = 0.3 + random.normal(0.02);
    arrivals.push_back({t, [=](PoseFilter& f) { return f.addGyro(at(t), rate, at(t)); }});
    if (i % 20 == 0) {
      const double wrong = i == 100 || i == 220 ? 3.0 : 0.0;
      const PoseFix fix = fixAt({truth.x_m + random.normal(0.02) + wrong, truth.y_m, truth.yaw_rad});
      const double late = i == 0 ? t : t + delay_s;
      arrivals.push_back({late, [=](PoseFilter& f) { return f.addPose(at(t), fix, at(late)); }});
      const LandmarkSighting seen =
          sightingOf({3.0, 2.0}, (Eigen::Vector2d(3.0, 2.0) - truth.position()).norm() + random.normal(0.1),
                     bearingTo(truth, {3.0, 2.0}));
      arrivals.push_back({late, [=](PoseFilter& f) { return f.addSighting(at(t), seen, at(late)); }});
    }
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.received_s < b.received_s; });
  return arrivals;
}

TEST(PoseFilter, DelayedMeasurementsEqualUndelayedOnes) {
  PoseFilter prompt{PoseFilterParams{}};
  PoseFilter delayed{PoseFilterParams{}};
  for (const Arrival& arrival : recordedDrive(0.0)) arrival.hand_over(prompt);
  for (const Arrival& arrival : recordedDrive(0.3)) arrival.hand_over(delayed);
  EXPECT_EQ(prompt.counts().of(FilterInput::kPose, FilterStatus::kGated), 2U);
  EXPECT_GT(delayed.counts().late, 20U);
  const PoseEstimate a = *prompt.estimateAt(at(3.0));
  const PoseEstimate b = *delayed.estimateAt(at(3.0));
  EXPECT_EQ(a.map_from_base.x_m, b.map_from_base.x_m);  // the same sums in the same order
  EXPECT_EQ(a.map_from_base.yaw_rad, b.map_from_base.yaw_rad);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.gyro_bias_radps, b.gyro_bias_radps);
}

TEST(PoseFilter, RefusesWhatIsOlderThanItsHistory) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({}), at(0.0));
  drive(filter, 0.0, 5.0, {0.3, 0.0});
  EXPECT_EQ(filter.addPose(at(2.9), fixAt({}), at(5.0)), FilterStatus::kTooOld);
  EXPECT_EQ(filter.addPose(at(3.1), fixAt({0.93, 0.0, 0.0}), at(5.0)), FilterStatus::kUsed);
  EXPECT_FALSE(filter.estimateAt(at(2.9)));
  EXPECT_TRUE(filter.estimateAt(at(3.1)));
}

TEST(PoseFilter, GatesWhatIsImprobable) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({}), at(0.0));
  drive(filter, 0.0, 1.0, {0.3, 0.0});
  const PoseEstimate before = *filter.estimate();
  EXPECT_EQ(filter.addPose(at(1.0), fixAt({1.3, 0.0, 0.0}), at(1.0)), FilterStatus::kGated);
  EXPECT_EQ(filter.addPose(at(1.0), fixAt({0.3, 0.0, 0.6}), at(1.0)),
            FilterStatus::kGated);  // a flipped marker
  EXPECT_EQ(filter.addSighting(at(1.0), sightingOf({4.0, 0.0}, 3.7, 0.8), at(1.0)), FilterStatus::kGated);
  EXPECT_EQ(filter.estimate()->map_from_base.x_m, before.map_from_base.x_m);
  EXPECT_EQ(filter.estimate()->covariance, before.covariance);
  EXPECT_EQ(filter.addPose(at(1.0), fixAt({0.31, 0.0, 0.0}), at(1.0)), FilterStatus::kUsed);
}

TEST(PoseFilter, YawInnovationIsWrapped) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({0.0, 0.0, M_PI - 0.01}), at(0.0));
  EXPECT_EQ(filter.addPose(at(0.1), fixAt({0.0, 0.0, -M_PI + 0.01}), at(0.1)), FilterStatus::kUsed);
  EXPECT_NEAR(std::abs(filter.estimate()->map_from_base.yaw_rad), M_PI, 0.011);
}

TEST(PoseFilter, StartsAnewFromPosesThatKeepContradictingIt) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({}), at(0.0));
  for (int i = 1; i <= 21; ++i) {  // carried away, wheels standing; at 10 Hz the 15th is too early
    filter.addEncoders(at(0.1 * i), {0.0, 0.0}, at(0.1 * i));
    const FilterStatus status = filter.addPose(at(0.1 * i), fixAt({4.0, 1.0, 0.0}), at(0.1 * i));
    EXPECT_EQ(status, i < 21 ? FilterStatus::kGated : FilterStatus::kUsed) << i;
  }
  EXPECT_EQ(filter.counts().restarts, 1U);
  EXPECT_EQ(filter.estimate()->map_from_base.x_m, 4.0);
}

/// What a drive of 6 s along x at 0.3 m/s comes to when each pose of 10 Hz is one that the filter refuses.
PoseFilter refusedFor6s(const std::function<Pose2(int, const Pose2&)>& wrong) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({}), at(0.0));
  for (int i = 1; i <= 60; ++i) {
    for (int k = 0; k < 5; ++k)
      filter.addEncoders(at(0.1 * (i - 1) + 0.02 * k), {0.3, 0.0}, at(0.1 * (i - 1) + 0.02 * k));
    const Pose2 truth{0.03 * i, 0.0, 0.0};
    filter.addPose(at(0.1 * i), fixAt(wrong(i, truth)), at(0.1 * i));
  }
  return filter;
}

TEST(PoseFilter, StartsAnewOnlyFromPosesThatAgreeWithEachOther) {
  const Pose2 carried{3.0, -1.0, 1.5};
  const PoseFilter moved = refusedFor6s([&](int, const Pose2& truth) { return carried * truth; });
  EXPECT_EQ(moved.counts().restarts, 1U);
  EXPECT_LT(distance(moved.estimate()->map_from_base, carried * Pose2{1.8, 0.0, 0.0}), 0.05);
  // One that stays in its place while the robot drives, and two places by turns.
  const PoseFilter stuck = refusedFor6s([&](int, const Pose2&) { return carried; });
  EXPECT_EQ(stuck.counts().restarts, 0U);
  const PoseFilter by_turns = refusedFor6s([&](int i, const Pose2& truth) {
    return (i % 2 == 0 ? carried : Pose2{-2.0, 0.0, 0.0}) * truth;
  });
  EXPECT_EQ(by_turns.counts().restarts, 0U);
  EXPECT_NEAR(by_turns.estimate()->map_from_base.x_m, 1.8, 0.02);
}

TEST(PoseFilter, ARestartThatALateInputBringsAboutIsCounted) {
  PoseFilterParams params;
  params.restart_after_s = 0.0;
  params.restart_after_gated = 3;
  PoseFilter filter{params};
  filter.addPose(at(0.0), fixAt({}), at(0.0));
  filter.addPose(at(0.2), fixAt({4.0, 0.0, 0.0}), at(0.2));
  filter.addPose(at(0.3), fixAt({4.0, 0.0, 0.0}), at(0.3));
  EXPECT_EQ(filter.counts().restarts, 0U);
  filter.addPose(at(0.1), fixAt({4.0, 0.0, 0.0}), at(0.4));  // the first of the three comes last
  EXPECT_EQ(filter.counts().restarts, 1U);
  EXPECT_EQ(filter.estimate()->map_from_base.x_m, 4.0);
}

// Images of one view err alike: a thousand of them must not make the covariance a thousandth of one's.
TEST(PoseFilter, StandingItDoesNotGrowSureWithoutBound) {
  PoseFilter filter{PoseFilterParams{}};
  const PoseFix fix = fixAt({1.0, 2.0, 0.5}, 0.004);
  for (int i = 0; i <= 3000; ++i) {
    filter.addEncoders(at(0.02 * i), {0.0, 0.0}, at(0.02 * i));
    if (i % 3 == 0) filter.addPose(at(0.02 * i), fix, at(0.02 * i));
  }
  // Walk q and measurements of sigma s at a rate r settle at sqrt(q s / sqrt(r)): 0.0001 m/sqrt(s), 4 mm and
  // 17 Hz give 0.31 mm; without the walk it would be 4 mm / sqrt(1000) = 0.13 mm.
  const double settled_m = std::sqrt(1e-4 * 0.004 / std::sqrt(50.0 / 3.0));
  EXPECT_NEAR(std::sqrt(filter.estimate()->covariance(0, 0)), settled_m, 0.1 * settled_m);
  EXPECT_NEAR(filter.estimate()->map_from_base.x_m, 1.0, 1e-9);
}

TEST(PoseFilter, WheelsThatWereSilentAreNotBelievedToHaveStood) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({}), at(0.0));
  drive(filter, 0.0, 1.0, {0.0, 0.0});
  for (int i = 100; i < 200; ++i) filter.addGyro(at(0.01 * i), 0.05, at(0.01 * i));  // pushed and turned
  const double bias_radps = filter.estimate()->gyro_bias_radps;
  filter.addEncoders(at(2.0), {0.0, 0.0}, at(2.0));  // standing, since now
  filter.addGyro(at(2.01), 0.05, at(2.01));
  EXPECT_EQ(filter.estimate()->gyro_bias_radps, bias_radps);
}

TEST(PoseFilter, NamesAndCountsBadInput) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({}), at(0.0));
  drive(filter, 0.0, 0.5, {0.3, 0.0});
  const PoseEstimate before = *filter.estimate();
  PoseFix asymmetric = fixAt({0.15, 0.0, 0.0});
  asymmetric.covariance(0, 1) = 1e-3;
  PoseFix negative = fixAt({0.15, 0.0, 0.0});
  negative.covariance(2, 2) = -1e-3;

  const Stamp now = at(0.5);
  EXPECT_EQ(filter.addEncoders(now, {kNan, 0.0}, now), FilterStatus::kNotFinite);
  EXPECT_EQ(filter.addGyro(now, kNan, now), FilterStatus::kNotFinite);
  EXPECT_EQ(filter.addPose(now, fixAt({0.0, kNan, 0.0}), now), FilterStatus::kNotFinite);
  EXPECT_EQ(filter.addPose(now, fixAt({0.0, 0.0, 0.0}, kNan), now), FilterStatus::kNotFinite);
  EXPECT_EQ(filter.addPose(now, asymmetric, now), FilterStatus::kBadCovariance);
  EXPECT_EQ(filter.addPose(now, negative, now), FilterStatus::kBadCovariance);
  EXPECT_EQ(filter.setPose(now, fixAt({kNan, 0.0, 0.0}), now), FilterStatus::kNotFinite);
  EXPECT_EQ(filter.addSighting(now, sightingOf({1.0, 0.0}, HUGE_VAL, 0.0), now), FilterStatus::kNotFinite);
  EXPECT_EQ(filter.addPose(at(0.7), fixAt({0.2, 0.0, 0.0}), now), FilterStatus::kFromFuture);
  EXPECT_EQ(filter.addGyro(at(9.0), 0.0, now), FilterStatus::kFromFuture);

  EXPECT_EQ(filter.counts().of(FilterInput::kPose, FilterStatus::kNotFinite), 3U);
  EXPECT_EQ(filter.counts().of(FilterInput::kPose, FilterStatus::kBadCovariance), 2U);
  EXPECT_EQ(filter.counts().of(FilterInput::kGyro, FilterStatus::kFromFuture), 1U);
  EXPECT_STREQ(toText(FilterStatus::kFromFuture), "stamp from the future");
  EXPECT_EQ(filter.estimate()->stamp, before.stamp);
  EXPECT_EQ(filter.estimate()->covariance, before.covariance);
}

TEST(PoseFilter, TimeThatJumpsBackStartsItAnew) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(10.0), fixAt({1.0, 2.0, 0.0}), at(10.0));
  drive(filter, 10.0, 11.0, {0.3, 0.0});
  filter.addGyro(at(10.95), 0.0, at(10.95));  // overtaken on its way, no jump
  EXPECT_EQ(filter.counts().time_jumps, 0U);
  drive(filter, 0.0, 1.0, {0.3, 0.0});
  EXPECT_EQ(filter.counts().time_jumps, 1U);
  EXPECT_FALSE(filter.estimate());
  filter.addPose(at(1.0), fixAt({1.0, 2.0, 0.0}), at(1.0));
  EXPECT_TRUE(filter.estimate());
}

TEST(PoseFilter, SurvivesAGapOfFiveSeconds) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({}), at(0.0));
  drive(filter, 0.0, 1.0, {0.3, 0.0});
  const PoseEstimate after = *filter.estimateAt(at(6.0));
  EXPECT_EQ(after.source, MotionSource::kNone);
  // Believed for the time-out of 0.25 s; then 0.5 m/sqrt(s) each way for 4.75 s.
  EXPECT_NEAR(after.map_from_base.x_m, 0.3 * 1.25, 1e-9);
  EXPECT_NEAR(std::sqrt(after.covariance(0, 0)), 0.5 * std::sqrt(4.75), 0.02);
  EXPECT_NEAR(std::sqrt(after.covariance(1, 1)), 0.5 * std::sqrt(4.75), 0.02);
  EXPECT_NEAR(std::sqrt(after.covariance(2, 2)), 0.5 * std::sqrt(4.75), 0.02);
  drive(filter, 6.0, 6.5, {0.3, 0.0});
  EXPECT_EQ(filter.addPose(at(6.5), fixAt({1.8, 0.4, 0.3}), at(6.5)), FilterStatus::kUsed);
  EXPECT_NEAR(filter.estimate()->map_from_base.y_m, 0.4, 0.01);
}

TEST(PoseFilter, GoesOnWithoutTheGyro) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({}), at(0.0));
  for (int i = 0; i <= 100; ++i) filter.addEncoders(at(0.02 * i), {0.3, 0.5}, at(0.02 * i));
  EXPECT_EQ(filter.estimate()->source, MotionSource::kTwistOnly);
  EXPECT_NEAR(filter.estimate()->map_from_base.yaw_rad, 1.0, 1e-9);
  EXPECT_NEAR(filter.estimate()->map_from_base.x_m, arcMotion({0.3, 0.5}, 2.0).x_m, 1e-9);
}

TEST(PoseFilter, GoesOnWithTheGyroAlone) {
  PoseFilter filter{PoseFilterParams{}};
  filter.addPose(at(0.0), fixAt({}), at(0.0));
  for (int i = 0; i <= 200; ++i) filter.addGyro(at(0.01 * i), 0.5, at(0.01 * i));
  const PoseEstimate estimate = *filter.estimate();
  EXPECT_EQ(estimate.source, MotionSource::kGyroOnly);
  EXPECT_NEAR(estimate.map_from_base.yaw_rad, 1.0, 1e-9);
  EXPECT_EQ(estimate.map_from_base.x_m, 0.0);
  EXPECT_GT(std::sqrt(estimate.covariance(1, 1)), 0.5);  // it may have driven anywhere
  EXPECT_LT(std::sqrt(estimate.covariance(2, 2)), 0.06);
}

TEST(PoseFilter, SwitchedOffInputsAreRefused) {
  PoseFilter filter{PoseFilterParams{}};
  filter.setEnabled(FilterInput::kPose, false);
  EXPECT_EQ(filter.addPose(at(0.0), fixAt({}), at(0.0)), FilterStatus::kDisabled);
  EXPECT_EQ(filter.setPose(at(0.0), fixAt({}), at(0.0)), FilterStatus::kUsed);  // that is not a measurement
  filter.setEnabled(FilterInput::kPose, true);
  EXPECT_EQ(filter.addPose(at(0.1), fixAt({}), at(0.1)), FilterStatus::kUsed);
  filter.setEnabled(FilterInput::kGyro, false);
  drive(filter, 0.1, 1.0, {0.3, 0.0});
  EXPECT_EQ(filter.estimate()->source, MotionSource::kTwistOnly);
}

TEST(PoseFilter, TakesTheTwistOfItsSourceOnly) {
  PoseFilterParams params;
  params.twist_source = "command";
  PoseFilter filter{params};
  filter.addPose(at(0.0), fixAt({}), at(0.0));
  EXPECT_EQ(filter.addEncoders(at(0.0), {1.0, 0.0}, at(0.0)), FilterStatus::kDisabled);
  EXPECT_EQ(filter.addCommand(at(0.0), {0.5, 0.0}, at(0.0)), FilterStatus::kUsed);
  filter.addCommand(at(0.2), {0.0, 0.0}, at(0.2));  // a command holds until the next: 0.5 m/s for 0.2 s
  EXPECT_NEAR(filter.estimate()->map_from_base.x_m, 0.1, 1e-12);
}

TEST(PoseFilter, SetPoseMovesTheRobotAndKeepsTheBiases) {
  PoseFilter filter{PoseFilterParams{}};
  drive(filter, 0.0, 5.0, {0.0, 0.0}, 0.03);
  EXPECT_EQ(filter.setPose(at(5.0), fixAt({7.0, -3.0, 2.0}), at(5.0)), FilterStatus::kUsed);
  const PoseEstimate estimate = *filter.estimate();
  EXPECT_EQ(estimate.map_from_base.x_m, 7.0);
  EXPECT_NEAR(estimate.gyro_bias_radps, 0.03, 1e-4);
  // A pose from before, come late, changes nothing.
  filter.addPose(at(4.9), fixAt({0.0, 0.0, 0.0}), at(5.0));
  EXPECT_EQ(filter.estimate()->map_from_base.x_m, 7.0);
}

}  // namespace
}  // namespace frugal_nav
