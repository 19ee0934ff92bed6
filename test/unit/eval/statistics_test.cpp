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

}  // namespace
}  // namespace frugal_nav::eval
