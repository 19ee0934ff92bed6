#include <gtest/gtest.h>

#include <frugal_nav/eval/statistics.hpp>

namespace frugal_nav::eval {
namespace {

TEST(Statistics, WilsonIntervalAgreesWithPublishedValues) {
  // 81 of 263: 0.2553..0.3662, from R. G. Newcombe, Statistics in Medicine 17 (1998), table I, method 3.
  const Interval many = wilsonInterval(81, 263);
  EXPECT_NEAR(many.low, 0.2553, 5e-5);
  EXPECT_NEAR(many.high, 0.3662, 5e-5);
  const Interval none = wilsonInterval(0, 20);
  EXPECT_NEAR(none.low, 0.0, 1e-12);
  EXPECT_NEAR(none.high, 0.1611, 5e-5);
}

TEST(Statistics, NothingHasNoMean) {
  EXPECT_FALSE(mean({}));
  EXPECT_FALSE(rootMeanSquare({}));
  EXPECT_DOUBLE_EQ(*mean({1.0, 2.0, 6.0}), 3.0);
  EXPECT_DOUBLE_EQ(*rootMeanSquare({3.0, -3.0}), 3.0);
}

TEST(Statistics, ChiSquaredTailAgreesWithTables) {
  // Critical values of 5 % (Abramowitz and Stegun, table 26.8).
  EXPECT_NEAR(chiSquaredTail(3.841459, 1), 0.05, 1e-6);
  EXPECT_NEAR(chiSquaredTail(5.991465, 2), 0.05, 1e-6);
  EXPECT_NEAR(chiSquaredTail(7.814728, 3), 0.05, 1e-6);
  EXPECT_NEAR(chiSquaredTail(9.487729, 4), 0.05, 1e-6);
}

/// 50 trials at three speeds: trial k succeeds at the speeds whose number of successes exceeds k.
std::vector<std::vector<bool>> nested(int first, int second, int third) {
  std::vector<std::vector<bool>> trials;
  for (int k = 0; k < 50; ++k) trials.push_back({k < first, k < second, k < third});
  return trials;
}

TEST(Statistics, CochranQOfThePapersCountsIsThePapersValue) {
  // 43, 39 and 33 of 50: Q = 15.20, p = 0.0005 (paper 000), which needs nested outcomes.
  const auto test = cochranQ(nested(43, 39, 33));
  ASSERT_TRUE(test);
  EXPECT_NEAR(test->statistic, 15.20, 0.005);
  EXPECT_NEAR(test->p, 0.0005, 5e-5);
}

TEST(Statistics, CochranQDoesNotExistWhereNothingDiffers) {
  EXPECT_FALSE(cochranQ(nested(50, 50, 50)));
  EXPECT_FALSE(cochranQ(nested(20, 20, 20)));
  EXPECT_FALSE(cochranQ({}));
  EXPECT_FALSE(cochranQ({{true}, {false}}));
}

}  // namespace
}  // namespace frugal_nav::eval
