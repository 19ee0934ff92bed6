#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <frugal_nav/perception/metric_fit.hpp>

namespace frugal_nav {
namespace {

constexpr double kA = 2.0;
constexpr double kB = 0.05;

MetricSample sampleAt(double inverse_depth_pm, double z, Cue cue = Cue::kVo) {
  return {z, inverse_depth_pm, 0.01 * inverse_depth_pm, cue};
}

/// Samples of 1 / d = a z + b from 0.7 m to 5 m, z noisy by a share of it.
std::vector<MetricSample> samples(int count, double noise, Random& random, double a = kA, double b = kB) {
  std::vector<MetricSample> all;
  for (int i = 0; i < count; ++i) {
    const double inverse = 0.2 + 1.2 * i / std::max(1, count - 1);
    all.push_back(sampleAt(inverse, (inverse - b) / a * (1.0 + random.normal(noise))));
  }
  return all;
}

TEST(MetricFit, IsExactWithoutNoise) {
  Random random(500001);
  MetricFitParams params;
  params.shift_share = 100.0;  // no opinion of its own
  const auto fit = fitMetric(samples(50, 0.0, random), params, std::nullopt, random);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->a, kA, 1e-4);
  EXPECT_NEAR(fit->b, kB, 1e-4);
  EXPECT_EQ(fit->vo_points, 50);
}

TEST(MetricFit, LeavesOutliersOut) {
  Random random(500002);
  std::vector<MetricSample> all = samples(60, 0.02, random);
  for (int i = 0; i < 35; ++i) all.push_back(sampleAt(random.uniform(0.2, 1.4), random.uniform(0.0, 1.5)));
  const auto fit = fitMetric(all, MetricFitParams{}, std::nullopt, random);
  ASSERT_TRUE(fit);
  for (const double inverse : {0.3, 0.7, 1.2})
    EXPECT_NEAR(fit->inverseDepth((inverse - kB) / kA), inverse, 0.06 * inverse + 0.02);
}

// Noise of 25 % on z over a spread of 2: regression of 1/d on z would give a slope too low by the share of
// the noise in z's variance, about a sixth; the mean over 40 draws tells 3 %.
TEST(MetricFit, NoiseOfTheNetworkDoesNotFlattenTheSlope) {
  Random random(500003);
  MetricFitParams params;
  params.network_sigma = 0.2;
  params.shift_share = 100.0;
  params.max_residual = 1.0;
  double sum = 0.0;
  constexpr int kDraws = 40;
  for (int i = 0; i < kDraws; ++i) {
    const auto fit = fitMetric(samples(200, 0.2, random), params, std::nullopt, random);
    ASSERT_TRUE(fit);
    sum += fit->inverseDepth((1.2 - kB) / kA) - fit->inverseDepth((0.4 - kB) / kA);
  }
  EXPECT_NEAR(sum / kDraws, 0.8, 0.07);
}

TEST(MetricFit, OneDepthAloneGivesTheScaleWithoutShift) {
  Random random(500004);
  std::vector<MetricSample> all;
  for (int i = 0; i < 30; ++i) all.push_back(sampleAt(0.5, 0.25 * (1.0 + random.normal(0.02))));
  const auto fit = fitMetric(all, MetricFitParams{}, std::nullopt, random);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->a, 2.0, 0.2);
  EXPECT_NEAR(fit->inverseDepth(0.25), 0.5, 0.02);
  EXPECT_GT(fit->inverseDepthSigma(0.75) / fit->inverseDepth(0.75),
            2.0 * fit->inverseDepthSigma(0.25) / fit->inverseDepth(0.25));  // it knows that it guesses there
}

TEST(MetricFit, RefusesTooFewAndThoseThatDisagree) {
  Random random(500005);
  EXPECT_FALSE(fitMetric(samples(7, 0.0, random), MetricFitParams{}, std::nullopt, random));
  std::vector<MetricSample> chaos;
  for (int i = 0; i < 80; ++i) chaos.push_back(sampleAt(random.uniform(0.2, 1.4), random.uniform(0.0, 1.5)));
  EXPECT_FALSE(fitMetric(chaos, MetricFitParams{}, std::nullopt, random));
  std::vector<MetricSample> nans = samples(20, 0.0, random);
  for (MetricSample& sample : nans) sample.z = std::nan("");
  EXPECT_FALSE(fitMetric(nans, MetricFitParams{}, std::nullopt, random));
}

/// An upright thing taken for floor: z is one while the floor's depth runs.
TEST(MetricFit, RefusesAThingTakenForFloor) {
  Random random(500006);
  std::vector<MetricSample> all;
  for (int i = 0; i < 80; ++i)
    all.push_back(sampleAt(0.2 + 0.7 * i / 79.0, 0.6 * (1.0 + random.normal(0.02)), Cue::kFloor));
  EXPECT_FALSE(fitMetric(all, MetricFitParams{}, std::nullopt, random));
}

TEST(MetricFit, ManyPointsOfOneCueDoNotDrownAnother) {
  Random random(500007);
  std::vector<MetricSample> all;
  for (int i = 0; i < 2000; ++i)
    all.push_back(sampleAt(0.2 + 0.7 * i / 1999.0, 0.1 + 0.35 * i / 1999.0, Cue::kFloor));
  for (int i = 0; i < 30; ++i) all.push_back(sampleAt(0.2 + 0.7 * i / 29.0, 1.15 * (0.1 + 0.35 * i / 29.0)));
  const auto fit = fitMetric(all, MetricFitParams{}, std::nullopt, random);
  ASSERT_TRUE(fit);
  const double between = fit->inverseDepth(0.3) / 0.6;  // 1 by the floor, 1 / 1.15 by the points
  EXPECT_LT(between, 0.97);
  EXPECT_GT(between, 0.90);
}

class Filter : public testing::Test {
 protected:
  const MetricFit& show(double a, double b = kB) {
    stamp_ += fromSeconds(0.2);
    return filter_.update(stamp_, samples(60, 0.02, random_, a, b));
  }
  Random random_{500010};
  MetricFilter filter_{MetricFitParams{}};
  Stamp stamp_ = stampFromSeconds(10.0);
};

TEST_F(Filter, BecomesSurer) {
  show(kA);
  const double first = filter_.fit().inverseDepthSigma(0.3);
  for (int i = 0; i < 10; ++i) show(kA);
  EXPECT_LT(filter_.fit().inverseDepthSigma(0.3), first);
  EXPECT_NEAR(filter_.fit().inverseDepth(0.3), kA * 0.3 + kB, 0.03);
}

TEST_F(Filter, LeavesOneJumpOutAndBelievesALastingOne) {
  for (int i = 0; i < 10; ++i) show(kA);
  show(6.0);
  EXPECT_NEAR(filter_.fit().inverseDepth(0.3), kA * 0.3 + kB, 0.05);
  show(6.0);
  show(6.0);
  EXPECT_NEAR(filter_.fit().inverseDepth(0.15), 6.0 * 0.15 + kB, 0.09);
}

TEST_F(Filter, KeepsTheScaleWithoutSamplesAndForgetsItAtLast) {
  for (int i = 0; i < 5; ++i) show(kA);
  const double sigma = filter_.fit().inverseDepthSigma(0.3);
  filter_.update(stamp_ + fromSeconds(1.5), {});
  EXPECT_TRUE(filter_.fit().known);
  EXPECT_EQ(filter_.fit().vo_points, 0);
  EXPECT_GT(filter_.fit().inverseDepthSigma(0.3), sigma);
  filter_.update(stamp_ + fromSeconds(2.5), {});
  EXPECT_FALSE(filter_.fit().known);
}

}  // namespace
}  // namespace frugal_nav
