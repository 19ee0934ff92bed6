#include "flat_view.hpp"

#include <gmock/gmock.h>

#include <frugal_nav/perception/column_profile.hpp>
#include <frugal_nav/perception/gap_finder.hpp>

namespace frugal_nav {
namespace {

using State = ColumnProfile::State;
using testing::ElementsAre;

constexpr double kMargin_rad = 0.02;

class Profile : public testing::Test {
 protected:
  ColumnProfile profile(const cv::Mat& inverse, const cv::Mat& floor) const {
    return profileColumns(inverse, floor, view_.rays(), kMargin_rad);
  }
  test::FlatView view_;
};

TEST_F(Profile, IsTheLargestInverseDepthThatIsNoFloor) {
  view_.boards = {{2.0, -0.2, 0.2, 0.6}};
  const ColumnProfile seen = profile(view_.inverseDepth(), view_.floor());
  // The floor at the bottom is nearer than the board and does not count. On the optical axis' column the
  // depth of a board at x is x cos(5 deg) and less above: at the horizon x * cos(5 deg).
  EXPECT_NEAR(1.0F / seen.nearest[80], 2.0, 0.05);
  EXPECT_EQ(seen.states[80], State::kSeen);
  EXPECT_NEAR(1.0F / seen.nearest[5], 5.0, 0.2);
}

TEST_F(Profile, WhatIsAboveTheHorizonIsCeiling) {
  cv::Mat inverse = view_.inverseDepth();
  inverse.rowRange(0, 40).setTo(9.0);
  EXPECT_LT(profile(inverse, view_.floor()).nearest[80], 1.0F);
}

TEST_F(Profile, FloorUpToTheHorizonIsOpenAndBrokenFloorIsUnknown) {
  cv::Mat all_floor(view_.rays().grid(), CV_8UC1, cv::Scalar(255));
  cv::Mat inverse = view_.inverseDepth();
  EXPECT_EQ(profile(inverse, all_floor).states[80], State::kOpen);
  // What is not floor has no depth either: nothing is known of that column.
  all_floor.at<uchar>(90, 80) = 0;
  inverse.at<float>(90, 80) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(profile(inverse, all_floor).states[80], State::kUnknown);
  EXPECT_EQ(profile(inverse, all_floor).states[81], State::kOpen);
}

TEST(RelativeDepth, IsClippedAndUnknownIsNear) {
  ColumnProfile profile;
  profile.states = {State::kSeen, State::kSeen, State::kOpen, State::kUnknown};
  profile.nearest = {0.5F, 0.0F, 0.0F, 0.0F};
  EXPECT_THAT(relativeDepths(profile, 0.01F, 30.0F), ElementsAre(2.0F, 30.0F, 30.0F, 0.0F));
}

TEST(Threshold, IsTheMean) {
  EXPECT_THAT(thresholdAtMean({1.0F, 2.0F, 3.0F, 6.0F}, 100.0F), ElementsAre(1, 1, 1, 0));
  EXPECT_THAT(thresholdAtMean({1.0F, 1.0F}, 100.0F), ElementsAre(1, 1));
}

TEST(Threshold, AllOpenStaysOpen) { EXPECT_THAT(thresholdAtMean({9.0F, 9.0F}, 9.0F), ElementsAre(0, 0)); }

TEST(NoiseRuns, ShortNearRunsAreFlippedAndOpenOnesAreNot) {
  std::vector<char> near = {1, 0, 1, 1, 0, 1, 1, 1, 0, 1};
  flipShortRuns(3, near);
  EXPECT_THAT(near, ElementsAre(0, 0, 0, 0, 0, 1, 1, 1, 0, 0));
}

TEST(LongestRun, IsTheFirstOfTheLongest) {
  const auto run = longestOpenRun({0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  ASSERT_TRUE(run);
  EXPECT_EQ(run->first, 3);
  EXPECT_EQ(run->last, 5);
  EXPECT_FALSE(longestOpenRun({1, 1}));
  EXPECT_FALSE(longestOpenRun({}));
}

TEST(Block, IsOneOfFiveEqualSegments) {
  EXPECT_EQ(blockOf(0.0, 160), -2);
  EXPECT_EQ(blockOf(31.4, 160), -2);  // (31.4 + 0.5) * 5 / 160 < 1
  EXPECT_EQ(blockOf(31.6, 160), -1);
  EXPECT_EQ(blockOf(79.5, 160), 0);
  EXPECT_EQ(blockOf(159.0, 160), 2);
}

// Literal: p + scale (i right + 1 forward). In the paper's frame, heading pi/2: (scale i, scale (y + 1)).
TEST(GapNode, LiteralIsThePapersWhenHeadingUp) {
  const Eigen::Vector2d node = literalGapNode({0.0, 0.4, M_PI / 2}, 2, 0.2);
  EXPECT_NEAR(node.x(), 0.4, 1e-12);
  EXPECT_NEAR(node.y(), 0.6, 1e-12);
  const Eigen::Vector2d left = literalGapNode({0.0, 0.0, 0.0}, -1, 0.2);
  EXPECT_NEAR(left.x(), 0.2, 1e-12);
  EXPECT_NEAR(left.y(), 0.2, 1e-12);
}

TEST(GapWidth, IsAcrossTheViewAtTheNearerBound) {
  EXPECT_NEAR(gapWidth(2.0, std::atan(0.25), std::atan(-0.1)), 2.0 * 0.35, 1e-12);
}

ColumnSurface hit(const ViewRays& rays, int column, float depth_m) {
  ColumnSurface surface;
  surface.state = ColumnSurface::State::kHit;
  surface.row = rays.grid().height / 2;
  surface.depth_m = depth_m;
  surface.p_base = rays.point(surface.row, column, depth_m).head<2>();
  return surface;
}

class Gaps : public testing::Test {
 protected:
  /// Surfaces at one depth, all columns.
  void wall(float depth_m) {
    surfaces_.clear();
    profile_ = {};
    for (int column = 0; column < 160; ++column) set(column, depth_m, true);
  }
  void set(int column, float depth_m, bool append = false) {
    const auto k = static_cast<std::size_t>(column);
    if (append) {
      surfaces_.emplace_back();
      profile_.states.push_back(State::kSeen);
      profile_.nearest.push_back(0.0F);
    }
    surfaces_[k] = hit(view_.rays(), column, depth_m);
    profile_.nearest[k] = 0.5F / depth_m;
  }
  GapSighting find() const {
    return findGap(openColumns(profile_, surfaces_, params_), surfaces_, view_.rays(), pose_, params_);
  }

  test::FlatView view_;
  Pose2 pose_;
  GapFinderParams params_;
  ColumnProfile profile_;
  std::vector<ColumnSurface> surfaces_;
};

// Columns 60..99 are open between things at 1.5 m and 2 m: their edges lie at columns 59.5 and 99.5, that is
// 240 px + 1.5 and 398 + 1.5 of the image, x = (px - 319.5) / 532.
TEST_F(Gaps, LieBetweenWhatBoundsThem) {
  wall(1.5F);
  for (int column = 60; column < 100; ++column) set(column, 6.0F);
  for (int column = 100; column < 160; ++column) set(column, 2.0F);
  const GapSighting gap = find();
  ASSERT_TRUE(gap.found) << gap.reason;
  EXPECT_NEAR(gap.left_column_px, 239.5, 0.01);
  EXPECT_NEAR(gap.right_column_px, 399.5, 0.01);
  EXPECT_NEAR(gap.depth_m, 1.5, 1e-6);
  // At the horizon of a camera pitched by 5 degrees bearings are wider by 1 / cos(5 deg).
  EXPECT_NEAR(gap.width_m, 1.5 * 160.0 / 532.0 / std::cos(5.0 * M_PI / 180.0), 0.01);
  EXPECT_EQ(gap.block, 0);
  EXPECT_GT(gap.left_bearing_rad, gap.right_bearing_rad);
  EXPECT_NEAR(gap.bearing_rad, 0.0, 0.01);
  EXPECT_NEAR(gap.p_odom.x(), 1.5, 0.01);
  EXPECT_NEAR(gap.p_odom.y(), 0.0, 0.01);
}

TEST_F(Gaps, NodeTurnsWithTheRobot) {
  wall(1.5F);
  for (int column = 10; column < 50; ++column) set(column, 6.0F);
  pose_ = {1.0, 2.0, M_PI / 2};
  const GapSighting gap = find();
  EXPECT_EQ(gap.block, -2);
  EXPECT_GT(gap.bearing_rad, 0.2);
  EXPECT_NEAR(gap.p_odom.y(), 2.0 + 1.5, 0.01);
  EXPECT_LT(gap.p_odom.x(), 1.0);
  params_.node = "literal";
  const GapSighting literal = find();
  EXPECT_NEAR(literal.p_odom.x(), 1.0 - 2 * 0.2, 1e-9);
  EXPECT_NEAR(literal.p_odom.y(), 2.2, 1e-9);
}

// Half of a flat wall is always farther than the mean: no way leads through it.
TEST_F(Gaps, ANearWallHasNone) {
  wall(1.0F);
  for (int column = 0; column < 80; ++column) set(column, 1.1F);
  const GapSighting gap = find();
  EXPECT_FALSE(gap.found);
  EXPECT_EQ(gap.reason, "everything in view is near");
}

TEST_F(Gaps, UnknownColumnsAreNear) {
  wall(1.0F);
  for (int column = 60; column < 100; ++column) {
    const auto k = static_cast<std::size_t>(column);
    profile_.states[k] = State::kUnknown;
    profile_.nearest[k] = 0.0F;
    surfaces_[k].state = ColumnSurface::State::kUnknown;
  }
  EXPECT_FALSE(find().found);
}

// A pole two columns wide is shorter than the noise length, but it stands nearer than the clear distance.
TEST_F(Gaps, AThinPoleIsNotFlippedAwayOnceItsDistanceIsKnown) {
  wall(6.0F);
  for (int column = 80; column < 82; ++column) set(column, 1.0F);
  const GapSighting gap = find();
  ASSERT_TRUE(gap.found);
  EXPECT_LE(gap.right_column_px, 320.0);
}

TEST_F(Gaps, AllOpenIsOneGapAsWideAsWhatLiesBehind) {
  wall(4.0F);
  const GapSighting gap = find();
  ASSERT_TRUE(gap.found);
  EXPECT_NEAR(gap.width_m, 4.0 * 640.0 / 532.0 / std::cos(5.0 * M_PI / 180.0), 0.05);
}

}  // namespace
}  // namespace frugal_nav
