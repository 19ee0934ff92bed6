#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include <frugal_nav/control/alignment.hpp>

namespace frugal_nav {
namespace {

using Status = AlignmentStep::Status;

AlignmentStep once(std::optional<double> column) {
  return Alignment(AlignmentParams{}).update(stampFromSeconds(1.0), 640, column);
}

TEST(Alignment, TurnsLeftToATargetOnTheLeft) {
  const AlignmentStep step = once(200.0);
  EXPECT_EQ(step.status, Status::kTurningLeft);
  EXPECT_DOUBLE_EQ(step.error_px, 120.0);
  EXPECT_NEAR(step.w_radps, 1.5 * 120.0 / 640.0, 1e-12);
}

TEST(Alignment, TurnsRightToATargetOnTheRight) {
  const AlignmentStep step = once(440.0);
  EXPECT_EQ(step.status, Status::kTurningRight);
  EXPECT_DOUBLE_EQ(step.error_px, -120.0);
  EXPECT_NEAR(step.w_radps, -1.5 * 120.0 / 640.0, 1e-12);
}

TEST(Alignment, IsDoneWithinThreePerCentOfTheWidth) {
  for (const double column : {320.0, 320.0 - 19.2, 320.0 + 19.2}) {  // 0.03 * 640 = 19.2
    EXPECT_EQ(once(column).status, Status::kDone) << column;
    EXPECT_EQ(once(column).w_radps, 0.0);
  }
  EXPECT_EQ(once(320.0 - 19.3).status, Status::kTurningLeft);
  EXPECT_EQ(once(320.0 + 19.3).status, Status::kTurningRight);
}

TEST(Alignment, TurnsNeitherTooFastNorTooSlowly) {
  EXPECT_DOUBLE_EQ(once(0.0).w_radps, 0.6);
  EXPECT_DOUBLE_EQ(once(320.0 - 20.0).w_radps, 0.15);
}

TEST(Alignment, StandsAtOnceWhenTheTargetIsNotSeenAndFailsLater) {
  Alignment alignment(AlignmentParams{});
  alignment.update(stampFromSeconds(1.0), 640, 100.0);
  AlignmentStep step = alignment.update(stampFromSeconds(1.1), 640, std::nullopt);
  EXPECT_EQ(step.status, Status::kWaiting);
  EXPECT_EQ(step.w_radps, 0.0);
  EXPECT_EQ(alignment.update(stampFromSeconds(2.0), 640, std::nullopt).status, Status::kWaiting);
  step = alignment.update(stampFromSeconds(2.1), 640, std::nullopt);
  EXPECT_EQ(step.status, Status::kLost);
  EXPECT_EQ(step.w_radps, 0.0);
  EXPECT_EQ(alignment.update(stampFromSeconds(2.2), 640, 100.0).status, Status::kTurningLeft);
}

TEST(Alignment, WaitsForATargetItNeverSaw) {
  Alignment alignment(AlignmentParams{});
  EXPECT_EQ(alignment.update(stampFromSeconds(50.0), 640, std::nullopt).status, Status::kWaiting);
  EXPECT_EQ(alignment.update(stampFromSeconds(51.1), 640, std::nullopt).status, Status::kLost);
}

TEST(Alignment, StandsOnColumnsThatAreNoNumbers) {
  EXPECT_EQ(once(std::nan("")).status, Status::kWaiting);
  EXPECT_EQ(once(std::nan("")).w_radps, 0.0);
  EXPECT_EQ(Alignment(AlignmentParams{}).update(stampFromSeconds(1.0), 0, 10.0).status, Status::kWaiting);
}

TEST(Alignment, StartsAnewWhenTimeJumpsBack) {
  Alignment alignment(AlignmentParams{});
  alignment.update(stampFromSeconds(10.0), 640, 100.0);
  alignment.update(stampFromSeconds(11.5), 640, std::nullopt);
  EXPECT_EQ(alignment.update(stampFromSeconds(5.0), 640, std::nullopt).status, Status::kWaiting);
}

// A robot that turns as told, 62 degrees wide, 10 frames a second: the loop ends in the middle, without
// overshoot to the other side, from either edge.
TEST(Alignment, ConvergesOnATurningRobot) {
  for (const double start_rad : {-0.5, 0.5}) {
    Alignment alignment(AlignmentParams{});
    double bearing_rad = start_rad;
    Status last = Status::kWaiting;
    int frames = 0;
    for (; frames < 100 && last != Status::kDone; ++frames) {
      const double column = 320.0 - 532.0 * std::tan(bearing_rad);
      const AlignmentStep step = alignment.update(stampFromSeconds(0.1 * frames), 640, column);
      EXPECT_GE(step.w_radps * start_rad, 0.0);
      bearing_rad -= 0.1 * step.w_radps;
      last = step.status;
    }
    EXPECT_EQ(last, Status::kDone);
    EXPECT_LT(frames, 40);
    EXPECT_LT(std::abs(bearing_rad), 0.037);  // 19.2 px of 532
  }
}

TEST(Alignment, TakesABearingForTheColumnItHasInTheImage) {
  // 640 pixels and 62 degrees: f = 320 / tan(31 degrees) = 532.6; 0.2 rad to the left is column 320 - 108.0.
  constexpr double kView_rad = 62.0 / 180.0 * M_PI;
  const double column = 320.0 - 320.0 / std::tan(0.5 * kView_rad) * std::tan(0.2);
  const AlignmentStep by_column = once(column);
  const AlignmentStep by_bearing =
      Alignment(AlignmentParams{}).updateBearing(stampFromSeconds(1.0), kView_rad, 0.2);
  EXPECT_EQ(by_bearing.status, Status::kTurningLeft);
  EXPECT_NEAR(by_bearing.w_radps, by_column.w_radps, 1e-12);
  const AlignmentStep behind =
      Alignment(AlignmentParams{}).updateBearing(stampFromSeconds(1.0), kView_rad, -3.0);
  EXPECT_EQ(behind.status, Status::kTurningRight);
  EXPECT_DOUBLE_EQ(behind.w_radps, -AlignmentParams{}.max_turn_radps);
}

}  // namespace
}  // namespace frugal_nav
