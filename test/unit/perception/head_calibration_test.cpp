#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <frugal_nav/perception/head_calibration.hpp>

namespace frugal_nav {
namespace {

HeadSighting headAt(double range_m) {
  HeadSighting head;
  head.status = HeadSighting::Status::kGood;
  head.range_m = range_m;
  return head;
}

/// A person's surface ahead, 0.3 m wide, before a wall.
LaserScan surfaces(double person_m, double wall_m = 4.9) {
  LaserScan scan;
  scan.angle_min_rad = -0.5;
  scan.angle_increment_rad = 0.01;
  scan.range_min_m = 0.1;
  scan.range_max_m = 5.0;
  for (int i = 0; i <= 100; ++i) {
    const bool person = std::abs(scan.angleOf(static_cast<std::size_t>(i))) < 0.15 / person_m;
    scan.ranges_m.push_back(static_cast<float>(person ? person_m : wall_m));
  }
  return scan;
}

TEST(HeadCalibration, TellsTheHeadsSizeFromWhereTheFeetStand) {
  HeadCalibration calibration{HeadCalibrationParams{}};
  for (int i = 0; i < 4; ++i) calibration.add(headAt(2.5), surfaces(2.85));
  EXPECT_EQ(calibration.factor(), 1.0) << "before enough is known";
  calibration.add(headAt(2.5), surfaces(2.85));
  EXPECT_NEAR(calibration.factor(), 3.0 / 2.5, 1e-6);  // the body's middle is 0.15 m behind its surface
  calibration.reset();
  EXPECT_EQ(calibration.factor(), 1.0);
}

TEST(HeadCalibration, OneWrongSurfaceChangesNothing) {
  HeadCalibration calibration{HeadCalibrationParams{}};
  for (int i = 0; i < 6; ++i) calibration.add(headAt(2.5), surfaces(i == 2 ? 2.0 : 2.35));
  EXPECT_NEAR(calibration.factor(), 1.0, 1e-6);
}

TEST(HeadCalibration, WhatStandsElsewhereIsNotThePerson) {
  HeadCalibration calibration{HeadCalibrationParams{}};
  for (int i = 0; i < 10; ++i) {
    calibration.add(headAt(3.5), surfaces(1.2));       // an obstacle hides the feet
    calibration.add(headAt(3.0), surfaces(4.2));       // the wall behind
    calibration.add(headAt(6.0), surfaces(4.8, 5.0));  // too far to tell
    LaserScan nothing = surfaces(2.85);
    for (float& range_m : nothing.ranges_m) range_m = std::numeric_limits<float>::quiet_NaN();
    calibration.add(headAt(2.5), nothing);
  }
  EXPECT_FALSE(calibration.isKnown());
}

TEST(HeadCalibration, BadParametersAreNamed) {
  HeadCalibrationParams params;
  params.min_samples = 30;
  EXPECT_THROW(HeadCalibration{params}, ConfigError);
}

}  // namespace
}  // namespace frugal_nav
