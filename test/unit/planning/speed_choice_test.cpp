#include <gtest/gtest.h>

#include <frugal_nav/planning/speed_choice.hpp>

namespace frugal_nav {
namespace {

constexpr BodyExtent kBody{0.125, 0.203};  // 0.16 m to the front

TEST(SpeedChoice, StopsWithinTheDistance) {
  const SpeedParams params;
  const SpeedChoice speed(params, kBody);
  for (const double distance_m : {0.0, 0.05, 0.3, 2.0}) {
    const double v = speed.stoppable_mps(distance_m);
    EXPECT_NEAR(v * params.reaction_s + v * v / (2.0 * params.brake_mps2), distance_m, 1e-9);
  }
}

TEST(SpeedChoice, FullSpeedStraightAheadInTheOpen) {
  const Twist2 twist = SpeedChoice({}, kBody).choose(0.0, 5.0, {});
  EXPECT_EQ(twist.v_mps, SpeedParams{}.max_v_mps);
  EXPECT_EQ(twist.w_radps, 0.0);
}

TEST(SpeedChoice, SlowerTheSharperTheTurnAndOnTheSpotAtLast) {
  const SpeedChoice speed({}, kBody);
  double last = speed.choose(0.0, 5.0, {}).v_mps;
  for (const double bearing_rad : {0.3, 0.6, 0.85}) {
    const Twist2 twist = speed.choose(bearing_rad, 5.0, {});
    EXPECT_LT(twist.v_mps, last);
    EXPECT_GT(twist.w_radps, 0.0);
    last = twist.v_mps;
  }
  EXPECT_EQ(speed.choose(-1.0, 5.0, {}).v_mps, 0.0);
  EXPECT_EQ(speed.choose(-3.0, 5.0, {}).w_radps, -SpeedParams{}.max_w_radps);
}

TEST(SpeedChoice, TurnsGentlyWhereThereIsRoomAndExactlyWhereThereIsNone) {
  const SpeedParams params;
  const SpeedChoice speed(params, kBody);
  const double small_rad = 0.2 * params.gentle_rad;
  const Eigen::Vector2d beside =
      Eigen::Rotation2Dd(small_rad) * Eigen::Vector2d(0.1, kBody.half_width_m + 1e-6);
  const double narrow = speed.choose(small_rad, 5.0, {beside}).w_radps;
  EXPECT_NEAR(narrow, params.turn_gain * small_rad, 1e-3);
  EXPECT_NEAR(speed.choose(small_rad, 5.0, {}).w_radps, 0.2 * params.turn_gain * small_rad, 1e-9);
  EXPECT_NEAR(speed.choose(-small_rad, 5.0, {}).w_radps, -0.2 * params.turn_gain * small_rad, 1e-9);
  EXPECT_NEAR(speed.choose(params.gentle_rad, 5.0, {}).w_radps, params.turn_gain * params.gentle_rad, 1e-9);
}

TEST(SpeedChoice, SlowsForWhatLiesAheadAndBeside) {
  const SpeedParams params;
  const SpeedChoice speed(params, kBody);
  // 0.10 m from the front, of which stop_short_m is kept: 0.05 m to stop in.
  const double ahead = speed.choose(0.0, 5.0, {{0.26, 0.0}}).v_mps;
  EXPECT_NEAR(ahead,
              std::max(speed.stoppable_mps(0.26 - kBody.front_m() - params.stop_short_m), params.min_v_mps),
              1e-9);
  const double beside = speed.choose(0.0, 5.0, {{0.1, 0.125 + 0.5 * params.full_clearance_m}}).v_mps;
  EXPECT_NEAR(beside, 0.5 * (params.min_v_mps + params.max_v_mps), 1e-9);
  EXPECT_EQ(speed.choose(0.0, 5.0, {{-0.5, 0.0}}).v_mps, params.max_v_mps) << "behind does not count";
}

}  // namespace
}  // namespace frugal_nav
