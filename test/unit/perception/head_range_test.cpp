#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/perception/head_range.hpp>

namespace frugal_nav {
namespace {

using Status = HeadSighting::Status;

Pinhole idealCamera() {
  Pinhole camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx = camera.fy = 500.0;
  camera.cx = 319.5;  // the middle of the image
  camera.cy = 239.5;
  return camera;
}

Pinhole bentCamera() {
  Pinhole camera = idealCamera();
  camera.k1 = 0.10;
  camera.k2 = -0.22;
  camera.p1 = 0.0005;
  camera.p2 = -0.0005;
  camera.k3 = 0.05;
  return camera;
}

/// A camera ahead of base_link, looking ahead and up.
Eigen::Isometry3d mounted(double x_m, double z_m, double pitch_up_rad) {
  Eigen::Matrix3d base_from_level;  // optical axes of a level camera as columns in base_link
  base_from_level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(-pitch_up_rad, Eigen::Vector3d::UnitY()) * base_from_level;
  pose.translation() = Eigen::Vector3d(x_m, 0.0, z_m);
  return pose;
}

Detection boxOf(double centre_x, double top, double bottom, double width = 40.0) {
  return {0, "head", 0.9, {centre_x - 0.5 * width, top, width, bottom - top}};
}

HeadRangeParams flatHead() {
  HeadRangeParams params;
  params.head_height_m = 0.25;
  params.head_depth_m = 0.0;
  params.min_above_floor_m = -10.0;
  params.max_above_floor_m = 10.0;
  return params;
}

// Paper 000, stage 1, by hand: Z = 500 * 0.25 / 50 = 2.5 m; 120 px left of the middle: beta = atan(120 / 500)
// = 13.50 deg, D = Z / cos(beta) = 2.5 * 1.02840 = 2.5710 m.
TEST(HeadRange, IsThePapersForAFlatHeadAndALevelCamera) {
  const HeadRange range(flatHead(), idealCamera(), mounted(0.0, 0.4, 0.0));
  const HeadSighting sighting = range.locate(boxOf(320 - 120, 60, 110));
  ASSERT_EQ(sighting.status, Status::kGood);
  EXPECT_NEAR(sighting.bearing_rad, std::atan(0.24), 1e-9);
  EXPECT_NEAR(sighting.range_m, 2.5710, 1e-4);
  EXPECT_NEAR(sighting.p_base.x(), 2.5, 1e-9);
  EXPECT_NEAR(sighting.p_base.y(), 2.5 * 0.24, 1e-9);
  // 155 px above the middle: 0.4 + 2.5 * 155 / 500.
  EXPECT_NEAR(sighting.above_floor_m, 1.175, 1e-9);
}

// The same flat head seen by a camera pitched 10 degrees up and moved 0.1 m ahead.
TEST(HeadRange, TakesTheCamerasPitchOut) {
  const double pitch = 10.0 * M_PI / 180.0;
  const Eigen::Isometry3d base_from_optical = mounted(0.1, 0.4, pitch);
  const HeadRange range(flatHead(), idealCamera(), base_from_optical);
  const auto row = [&](double above_m) {
    return idealCamera().project(base_from_optical.inverse() * Eigen::Vector3d(3.0, 0.5, above_m))->y() + 0.5;
  };
  const double column =
      idealCamera().project(base_from_optical.inverse() * Eigen::Vector3d(3.0, 0.5, 1.2))->x() + 0.5;
  const HeadSighting sighting = range.locate(boxOf(column, row(1.325), row(1.075)));
  ASSERT_EQ(sighting.status, Status::kGood);
  // What is left out is of second order in size over distance: (0.125 / 2.9)^2 = 0.2 %, 6 mm.
  EXPECT_NEAR(sighting.p_base.x(), 3.0, 0.006);
  EXPECT_NEAR(sighting.p_base.y(), 0.5, 0.006);
  EXPECT_NEAR(sighting.above_floor_m, 1.2, 0.006);
}

/// The box of an ellipsoid's outline, from points all over it.
Detection outlineOf(const Pinhole& camera, const Eigen::Isometry3d& base_from_optical,
                    const Eigen::Vector3d& centre, double depth_m, double height_m) {
  double low_u = 1e9, high_u = -1e9, low_v = 1e9, high_v = -1e9;
  const Eigen::Isometry3d optical_from_base = base_from_optical.inverse();
  for (int i = 0; i <= 180; ++i) {
    for (int j = 0; j < 360; ++j) {
      const double a = i * M_PI / 180.0;
      const double b = j * M_PI / 180.0;
      const Eigen::Vector3d p =
          centre + 0.5 * Eigen::Vector3d(depth_m * std::sin(a) * std::cos(b),
                                         depth_m * std::sin(a) * std::sin(b), height_m * std::cos(a));
      const Eigen::Vector2d pixel = *camera.project(optical_from_base * p);
      low_u = std::min(low_u, pixel.x());
      high_u = std::max(high_u, pixel.x());
      low_v = std::min(low_v, pixel.y());
      high_v = std::max(high_v, pixel.y());
    }
  }
  return {0, "head", 0.9, {low_u + 0.5, low_v + 0.5, high_u - low_u, high_v - low_v}};
}

// The camera of the robot (0.4 m high, 5 degrees up, a bent lens) below standing people: the paper's formula
// would be 4 to 6 % off at 2.3 m. What is left is of second order in size over distance, below half a per
// cent, and the curvature of the lens across the head.
TEST(HeadRange, IsRightForRoundHeadsSeenFromBelow) {
  const Eigen::Isometry3d base_from_optical = mounted(0.1, 0.4, 5.0 * M_PI / 180.0);
  HeadRangeParams params;
  params.head_height_m = 0.24;
  params.head_depth_m = 0.19;
  const HeadRange range(params, bentCamera(), base_from_optical);
  for (const double distance : {2.5, 3.0, 4.0, 6.0}) {
    for (const double aside : {-0.9, 0.0, 0.5}) {
      const Eigen::Vector3d centre(distance, aside, 1.35);
      const HeadSighting sighting =
          range.locate(outlineOf(bentCamera(), base_from_optical, centre, 0.19, 0.24));
      ASSERT_EQ(sighting.status, Status::kGood) << distance << ", " << aside;
      EXPECT_NEAR(sighting.range_m / centre.head<2>().norm(), 1.0, 0.01) << distance << ", " << aside;
      EXPECT_NEAR(sighting.bearing_rad, std::atan2(aside, distance), 0.003);
    }
  }
}

TEST(HeadRange, HasTheRightDerivative) {
  const HeadRange range(HeadRangeParams{}, bentCamera(), mounted(0.1, 0.4, 0.1));
  const double u = 150.0;
  const double top = 60.0;
  const double bottom = 100.0;
  const auto at = [&](double du, double dt, double db) {
    const HeadSighting sighting = range.locate(boxOf(u + du, top + dt, bottom + db));
    return Eigen::Vector3d(sighting.p_base.x(), sighting.p_base.y(), sighting.above_floor_m);
  };
  const double step = 1e-4;  // central differences: relative error about (step / 40)^2
  Eigen::Matrix3d numeric;
  numeric.col(0) = (at(step, 0, 0) - at(-step, 0, 0)) / (2 * step);
  numeric.col(1) = (at(0, step, 0) - at(0, -step, 0)) / (2 * step);
  numeric.col(2) = (at(0, 0, step) - at(0, 0, -step)) / (2 * step);
  const Eigen::Matrix3d analytic = range.locate(boxOf(u, top, bottom)).place_by_box;
  EXPECT_LT((analytic - numeric).cwiseAbs().maxCoeff(), 1e-6) << analytic << "\n\n" << numeric;
}

TEST(HeadRange, SaysHowNoisyItIs) {
  HeadRangeParams params;
  params.edge_noise_px = 1.0;
  params.edge_noise_share = 0.0;
  params.direction_noise_rad = 0.0;
  const HeadRange range(params, bentCamera(), mounted(0.1, 0.4, 0.1));
  const HeadSighting truth = range.locate(boxOf(200, 60, 100));
  Random random(500002);
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  const int draws = 20000;
  for (int i = 0; i < draws; ++i) {
    Detection noisy = boxOf(200, 60, 100);
    const double left = noisy.box.x + random.normal(1.0);
    const double right = noisy.box.x + noisy.box.width + random.normal(1.0);
    const double top = 60 + random.normal(1.0);
    const double bottom = 100 + random.normal(1.0);
    noisy.box = {left, top, right - left, bottom - top};
    const Eigen::Vector2d error = range.locate(noisy).p_base - truth.p_base;
    sum += error * error.transpose();
  }
  const Eigen::Matrix2d sampled = sum / draws;
  // A variance from 20000 draws is good to 1 %; h varies by 3.5 %, whose square enters at second order: 2 %
  // more.
  EXPECT_NEAR(sampled(0, 0) / truth.noise_m2(0, 0), 1.0, 0.04);
  EXPECT_NEAR(sampled(1, 1) / truth.noise_m2(1, 1), 1.0, 0.04);
  EXPECT_NEAR(sampled(0, 1) / truth.noise_m2(0, 1), 1.0, 0.06);
}

// A head 5 % larger than calibrated is 5 % farther along the ray, in every frame alike.
TEST(HeadRange, SaysWhatTheUnknownSizeOfHeadsMakes) {
  HeadRangeParams params = flatHead();
  params.head_height_share = 0.05;
  const HeadRange range(params, idealCamera(), mounted(0.0, 0.4, 0.0));
  const HeadSighting sighting = range.locate(boxOf(200, 60, 110));
  EXPECT_NEAR(sighting.size_sigma, 0.05, 1e-12);
  params.head_height_m *= 1.05;
  const HeadSighting larger =
      HeadRange(params, idealCamera(), mounted(0.0, 0.4, 0.0)).locate(boxOf(200, 60, 110));
  EXPECT_NEAR((larger.p_base - sighting.p_base - 0.05 * sighting.from_eye_m.head<2>()).norm(), 0.0, 1e-9);
  EXPECT_NEAR(larger.above_floor_m - sighting.above_floor_m, 0.05 * sighting.from_eye_m.z(), 1e-9);
}

// The camera's direction off by 0.01 rad moves a head at 3 m by 3 cm aside, and up.
TEST(HeadRange, CountsThatTheCameraRocks) {
  HeadRangeParams params = flatHead();
  params.direction_noise_rad = 0.0;
  const Detection box = boxOf(320, 200, 242);
  const HeadSighting still = HeadRange(params, idealCamera(), mounted(0.0, 0.4, 0.0)).locate(box);
  params.direction_noise_rad = 0.01;
  const HeadSighting rocks = HeadRange(params, idealCamera(), mounted(0.0, 0.4, 0.0)).locate(box);
  const double aside_m = 0.01 * still.from_eye_m.norm();
  EXPECT_NEAR(rocks.noise_m2(1, 1) - still.noise_m2(1, 1), aside_m * aside_m, 1e-9);
  EXPECT_NEAR(rocks.noise_m2(2, 2) - still.noise_m2(2, 2), aside_m * aside_m, 1e-9);
}

TEST(HeadRange, BelievesNoBoxThatIsNoWholeHead) {
  HeadRangeParams params;
  const HeadRange range(params, idealCamera(), mounted(0.0, 0.4, 0.0));
  EXPECT_EQ(range.locate(boxOf(320, 60, 100)).status, Status::kGood);
  EXPECT_EQ(range.locate(boxOf(320, 0, 60)).status, Status::kCutOff);
  EXPECT_EQ(range.locate(boxOf(15, 60, 100)).status, Status::kCutOff);
  EXPECT_EQ(range.locate(boxOf(320, 440, 479)).status, Status::kCutOff);
  EXPECT_EQ(range.locate(boxOf(320, 150, 161)).status, Status::kGood);
  EXPECT_EQ(range.locate(boxOf(320, 150, 159.9)).status, Status::kTooSmall);
  EXPECT_EQ(range.locate(boxOf(320, 300, 340)).status, Status::kImplausible);  // below the camera
  params.max_range_m = 2.0;
  EXPECT_EQ(HeadRange(params, idealCamera(), mounted(0.0, 0.4, 0.0)).locate(boxOf(320, 60, 100)).status,
            Status::kTooFar);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(range.locate(boxOf(nan, 60, 100)).status, Status::kNotFinite);
  EXPECT_EQ(range.locate(boxOf(320, 100, 60)).status, Status::kNotFinite);
}

TEST(HeadRange, RefusesACameraThatIsNotCalibrated) {
  Pinhole camera = idealCamera();
  camera.fx = camera.fy = 0.0;
  EXPECT_THROW(HeadRange(HeadRangeParams{}, camera, mounted(0.0, 0.4, 0.0)), ConfigError);
}

// 5 degrees up, 25.6 degrees to the image's upper edge: the top of a head at 1.82 m comes into view 2.4 m
// ahead.
TEST(HeadRange, KnowsWhetherAHeadWouldBeInView) {
  const HeadRange range(HeadRangeParams{}, idealCamera(), mounted(0.0, 0.4, 5.0 * M_PI / 180.0));
  EXPECT_TRUE(range.couldSee({3.0, 0.0}, 1.7));
  EXPECT_FALSE(range.couldSee({2.2, 0.0}, 1.7));
  EXPECT_FALSE(range.couldSee({3.0, 2.5}, 1.7));
  EXPECT_FALSE(range.couldSee({-3.0, 0.0}, 1.7));
}

}  // namespace
}  // namespace frugal_nav
