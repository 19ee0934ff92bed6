#include <cmath>

#include <gtest/gtest.h>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/odometry/wheel_calibration.hpp>

namespace frugal_nav {
namespace {

constexpr double kSide_m = 4.0;
constexpr double kSeparation_m = 0.21;

/// Where a robot of the true sizes ends that drives a square by an odometry which believes in others; the
/// odometry itself ends at the start, so this is the error.
Eigen::Vector2d endOfSquare(const WheelCalibration& truth, const WheelCalibration& believed,
                            double direction) {
  const double left = truth.left_radius_multiplier / believed.left_radius_multiplier;
  const double right = truth.right_radius_multiplier / believed.right_radius_multiplier;
  const double believed_b = kSeparation_m * believed.separation_multiplier;
  const double true_b = kSeparation_m * truth.separation_multiplier;
  const auto drive = [&](double left_m, double right_m) {
    return arcMotion({(right * right_m + left * left_m) / 2.0, (right * right_m - left * left_m) / true_b},
                     1.0);
  };
  Pose2 pose;
  for (int i = 0; i < 4; ++i) {
    const double turn_m = direction * M_PI / 4.0 * believed_b;
    pose = pose * drive(kSide_m, kSide_m) * drive(-turn_m, turn_m);
  }
  return pose.position();
}

SquareErrors squares(const WheelCalibration& truth, const WheelCalibration& believed, double noise_m,
                     std::uint64_t seed) {
  Random random(seed);
  SquareErrors errors;
  for (int i = 0; i < 5; ++i) {
    const auto noise = [&] { return Eigen::Vector2d(random.normal(noise_m), random.normal(noise_m)); };
    errors.clockwise.push_back(endOfSquare(truth, believed, -1.0) + noise());
    errors.counter_clockwise.push_back(endOfSquare(truth, believed, 1.0) + noise());
  }
  return errors;
}

struct Case {
  double ratio;       // right wheel over left wheel
  double separation;  // true over believed
};

class WheelCalibrationOf : public testing::TestWithParam<Case> {};

// The method is of first order in the errors. An angle error of e a leg leaves about e^2: here e is at most
// 0.19 rad (ratio 1.01 over 4 m), so one round takes away most of the error and a second one nearly all.
TEST_P(WheelCalibrationOf, FindsTheTrueSizes) {
  const WheelCalibration truth{2.0 / (GetParam().ratio + 1.0), 2.0 / (1.0 / GetParam().ratio + 1.0),
                               GetParam().separation};
  WheelCalibration believed;
  const double before_m =
      endOfSquare(truth, believed, 1.0).norm() + endOfSquare(truth, believed, -1.0).norm();
  for (int round = 0; round < 2; ++round) {
    const WheelCalibration found = calibrateWheels(squares(truth, believed, 0.0, 1), kSide_m,
                                                   kSeparation_m * believed.separation_multiplier);
    believed.left_radius_multiplier *= found.left_radius_multiplier;
    believed.right_radius_multiplier *= found.right_radius_multiplier;
    believed.separation_multiplier *= found.separation_multiplier;
    const double after_m =
        endOfSquare(truth, believed, 1.0).norm() + endOfSquare(truth, believed, -1.0).norm();
    EXPECT_LT(after_m, (round == 0 ? 0.3 : 0.03) * before_m + 1e-9) << "round " << round;
  }
  EXPECT_NEAR(believed.right_radius_multiplier / believed.left_radius_multiplier, GetParam().ratio, 2e-4);
  EXPECT_NEAR(believed.separation_multiplier, GetParam().separation, 2e-3);
  EXPECT_NEAR(believed.left_radius_multiplier + believed.right_radius_multiplier, 2.0, 1e-3)
      << "squares cannot tell the scale";
}
INSTANTIATE_TEST_SUITE_P(Sizes, WheelCalibrationOf,
                         testing::Values(Case{1.0, 1.0}, Case{1.004, 1.0}, Case{0.996, 1.0}, Case{1.0, 1.03},
                                         Case{1.0, 0.97}, Case{1.006, 1.03}, Case{0.993, 0.98},
                                         Case{1.01, 0.98}));

TEST(WheelCalibration, AveragesTheNoiseOfSeveralSquares) {
  const WheelCalibration truth{0.998, 1.002, 1.02};
  const WheelCalibration found = calibrateWheels(squares(truth, {}, 0.02, 500001), kSide_m, kSeparation_m);
  // alpha and beta are means of 20 errors of 2 cm over 2 x 4 m: 0.02 / sqrt(20) / 8 = 0.6 mrad; the ratio
  // varies by b / L of beta (3e-5), the separation by 2 / pi of alpha (4e-4). The systematic second order is
  // larger: 1e-3.
  EXPECT_NEAR(found.right_radius_multiplier / found.left_radius_multiplier, 1.002 / 0.998, 5e-4);
  EXPECT_NEAR(found.separation_multiplier, 1.02, 5e-3);
}

TEST(WheelCalibration, RefusesWhatItCannotUse) {
  const SquareErrors none;
  EXPECT_THROW(calibrateWheels(none, kSide_m, kSeparation_m), ConfigError);
  SquareErrors errors{{{0.1, 0.1}}, {{0.1, 0.1}}};
  EXPECT_NO_THROW(calibrateWheels(errors, kSide_m, kSeparation_m));
  EXPECT_THROW(calibrateWheels(errors, 0.0, kSeparation_m), ConfigError);
  errors.clockwise = {{100.0, 100.0}};
  EXPECT_THROW(calibrateWheels(errors, kSide_m, kSeparation_m), ConfigError);
  errors.clockwise = {{std::nan(""), 0.0}};
  EXPECT_THROW(calibrateWheels(errors, kSide_m, kSeparation_m), ConfigError);
}

}  // namespace
}  // namespace frugal_nav
