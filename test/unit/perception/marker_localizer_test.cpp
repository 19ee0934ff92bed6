#include "marker_view.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include <frugal_nav/perception/marker_detector.hpp>
#include <frugal_nav/perception/marker_localizer.hpp>

namespace frugal_nav {
namespace {

using test::cameraAt;
using test::mounted;
using test::seen;
using test::wallMap;
using Status = MarkerFix::Status;
using Use = MarkerSighting::Use;

MarkerMap only(std::set<int> ids) {
  MarkerMap map = wallMap();
  for (int id = 0; id < 4; ++id) {
    if (ids.count(id) == 0) map.markers.erase(id);
  }
  return map;
}

Eigen::Vector3d difference(const Pose2& from, const Pose2& to) {
  return {to.x_m - from.x_m, to.y_m - from.y_m, angleBetween(from.yaw_rad, to.yaw_rad)};
}

MarkerLocalizer localizer(const MarkerMap& map, const MarkerLocalizerParams& params = {}) {
  return MarkerLocalizer(params, map, test::bentCamera(), mounted());
}

TEST(MarkerLocalizer, IsExactOnExactCorners) {
  Random random(500020);
  for (int trial = 0; trial < 30; ++trial) {
    const Pose2 truth{random.uniform(1.0, 2.2), random.uniform(-0.4, 0.4), random.uniform(-0.15, 0.15)};
    const MarkerFix fix =
        localizer(wallMap()).locate(seen(wallMap(), test::bentCamera(), truth, 0.0, random));
    ASSERT_TRUE(fix.isGood()) << toText(fix.status);
    EXPECT_LT(difference(fix.map_from_base, truth).norm(), 1e-5);
    EXPECT_LT(fix.image_error_px, 1e-3);
    EXPECT_EQ(fix.sightings.size(), 4U);
  }
}

// Whole chain on pictures. Corners to 0.25 px (MarkerDetector's test) of sides of 25 px and more, at up to
// three metres: a single marker's range is good to 0.25 px / 25 px * 3 m = 3 cm and its bearing to 0.25 px /
// 530 px; several of them better.
TEST(MarkerLocalizer, FindsTheRobotInAPicture) {
  Random random(500021);
  test::MarkerLight light;
  light.noise = 4.0;
  const MarkerMap map = wallMap();
  MarkerDetectorParams params;
  params.dictionary = map.dictionary;
  const MarkerDetector detector(params, map.whitelist);
  for (int trial = 0; trial < 8; ++trial) {
    const Pose2 truth{random.uniform(0.9, 1.8), random.uniform(-0.3, 0.3), random.uniform(-0.1, 0.1)};
    const auto found = detector.detect(viewOf(map, test::bentCamera(), cameraAt(truth), light, random));
    ASSERT_GE(found.markers.size(), 3U) << "trial " << trial;
    const MarkerFix fix = localizer(map).locate(found.markers);
    ASSERT_TRUE(fix.isGood()) << toText(fix.status);
    const Eigen::Vector3d error = difference(fix.map_from_base, truth);
    EXPECT_LT(error.head<2>().norm(), 0.03) << "trial " << trial;
    EXPECT_LT(std::abs(error.z()), 0.5 * M_PI / 180.0) << "trial " << trial;
  }
}

// NEES of 400 draws with 3 degrees of freedom: mean 3, standard deviation of the mean sqrt(6 / 400) = 0.12.
// The floor is exact here while the covariance expects it to be soft, which takes up to the share of it that
// the floor decides: hence a wide floor, and a bound of 0.5.
TEST(MarkerLocalizer, CovarianceIsThatOfTheCornersNoise) {
  Random random(500022);
  MarkerLocalizerParams params;
  params.height_sigma_m = 5.0;
  params.tilt_sigma_deg = 60.0;
  const Pose2 truth{1.5, 0.2, -0.05};
  const MarkerLocalizer localize = localizer(wallMap(), params);
  constexpr int kTrials = 400;
  double sum = 0.0;
  double correlation = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const MarkerFix fix = localize.locate(seen(wallMap(), test::bentCamera(), truth, 0.3, random));
    ASSERT_TRUE(fix.isGood()) << toText(fix.status);
    const Eigen::Vector3d error = difference(fix.map_from_base, truth);
    sum += error.dot(fix.covariance.ldlt().solve(error));
    correlation = fix.covariance(1, 2) / std::sqrt(fix.covariance(1, 1) * fix.covariance(2, 2));
  }
  EXPECT_NEAR(sum / kTrials, 3.0, 0.5);
  // Turned to the left the markers move to the right, as they do for a robot farther left: y up, yaw down.
  EXPECT_LT(correlation, -0.8);
}

// The same with every marker hung 1 cm and half a degree off, each way, and no noise: the map's share alone.
TEST(MarkerLocalizer, CovarianceIsThatOfTheMapsErrorsToo) {
  Random random(500029);
  MarkerLocalizerParams params;
  params.height_sigma_m = 5.0;
  params.tilt_sigma_deg = 60.0;
  params.map_sigma_m = 0.01;
  params.map_sigma_deg = 0.5;
  params.pose.corner_sigma_px = 0.02;
  params.pose.max_image_error_px = 20.0;
  const double sigma_rad = 0.5 * M_PI / 180.0;
  const Pose2 truth{1.5, 0.2, -0.05};
  const MarkerLocalizer localize = localizer(only({0}), params);
  constexpr int kTrials = 400;
  double sum = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    MarkerMap hung = only({0});
    Eigen::Isometry3d& pose = hung.markers.at(0).map_from_marker;
    const Eigen::Vector3d turn(random.normal(sigma_rad), random.normal(sigma_rad), random.normal(sigma_rad));
    pose.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * pose.linear();
    pose.translation() += Eigen::Vector3d(random.normal(0.01), random.normal(0.01), random.normal(0.01));
    const MarkerFix fix = localize.locate(seen(hung, test::bentCamera(), truth, 0.0, random), truth);
    ASSERT_TRUE(fix.isGood()) << toText(fix.status);
    const Eigen::Vector3d error = difference(fix.map_from_base, truth);
    sum += error.dot(fix.covariance.ldlt().solve(error));
  }
  EXPECT_NEAR(sum / kTrials, 3.0, 0.5);
}

TEST(MarkerLocalizer, CornersThatFitBadlyTellLess) {
  Random random(500030);
  const Pose2 truth{1.5, 0.2, -0.05};
  const MarkerFix sharp =
      localizer(wallMap()).locate(seen(wallMap(), test::bentCamera(), truth, 0.1, random));
  const MarkerFix rough =
      localizer(wallMap()).locate(seen(wallMap(), test::bentCamera(), truth, 0.9, random));
  ASSERT_TRUE(sharp.isGood() && rough.isGood());
  // Three times the expected noise of 0.3 px: nine times the variance, less what the map's places add.
  EXPECT_GT(rough.covariance(2, 2), 4.0 * sharp.covariance(2, 2));
}

TEST(MarkerLocalizer, SeveralMarkersTellMoreThanOne) {
  Random random(500023);
  const Pose2 truth{1.5, 0.0, 0.0};
  const MarkerFix all =
      localizer(wallMap()).locate(seen(wallMap(), test::bentCamera(), truth, 0.1, random), truth);
  const MarkerFix one =
      localizer(only({0})).locate(seen(only({0}), test::bentCamera(), truth, 0.1, random), truth);
  ASSERT_TRUE(all.isGood()) << toText(all.status);
  ASSERT_TRUE(one.isGood()) << toText(one.status);
  EXPECT_LT(all.covariance.determinant(), 1e-2 * one.covariance.determinant());
}

// A single small marker seen from nearly ahead: the two solutions fit alike. Alone it must not be believed,
// with the odometry's word it must be right, and other markers settle it without any.
TEST(MarkerLocalizer, NeverTakesAFlipForTheRobot) {
  Random random(500024);
  int undecided = 0;
  int settled = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Pose2 truth{random.uniform(0.0, 1.5), random.uniform(-1.0, 1.0), 0.0};
    const Pose2 ahead{truth.x_m, truth.y_m, std::atan2(0.1 - truth.y_m, 4.0 - truth.x_m)};
    const MarkerLocalizer localize = localizer(only({2}));
    const auto corners = seen(only({2}), test::bentCamera(), ahead, 0.3, random);
    const MarkerFix alone = localize.locate(corners);
    const auto yawError = [&](const MarkerFix& fix) {
      return std::abs(angleBetween(fix.map_from_base.yaw_rad, ahead.yaw_rad));
    };
    if (alone.isGood()) {
      EXPECT_LT(yawError(alone), 0.35) << "trial " << trial;
    }
    if (alone.status != Status::kAmbiguous) continue;
    ++undecided;
    ASSERT_TRUE(alone.alternative);
    const Pose2 odometry{ahead.x_m + 0.1, ahead.y_m - 0.1, ahead.yaw_rad + 0.05};
    const MarkerFix told = localize.locate(corners, odometry);
    if (told.isGood()) {
      ++settled;
      EXPECT_LT(yawError(told), 0.5) << "trial " << trial;
    }
  }
  EXPECT_GT(undecided, 30);
  EXPECT_GT(settled, undecided / 2);
  for (int trial = 0; trial < 50; ++trial) {
    const Pose2 truth{random.uniform(0.5, 1.2), random.uniform(-0.3, 0.3), 0.0};
    const MarkerFix fix =
        localizer(only({0, 1, 2})).locate(seen(only({0, 1, 2}), test::bentCamera(), truth, 0.3, random));
    ASSERT_TRUE(fix.isGood()) << toText(fix.status);
    EXPECT_LT(std::abs(fix.map_from_base.yaw_rad), 0.1) << "trial " << trial;
  }
}

// Two markers whose second best place lies by the first one, with a flip, 8 degrees off, behind both.
TEST(MarkerLocalizer, LooksForAFlipPastAPlaceThatIsTheFirstOnceMore) {
  Random random(500373);
  Pose2 truth{random.uniform(-1.5, 1.5), random.uniform(-1.0, 1.0), 0.0};
  truth.yaw_rad = std::atan2(0.1 - truth.y_m, 4.0 - truth.x_m);
  const MarkerFix fix =
      localizer(only({0, 2})).locate(seen(only({0, 2}), test::bentCamera(), truth, 0.3, random));
  EXPECT_EQ(fix.status, Status::kAmbiguous);
  ASSERT_TRUE(fix.alternative);
  const double apart_rad = std::abs(angleBetween(fix.map_from_base.yaw_rad, fix.alternative->yaw_rad));
  EXPECT_GT(apart_rad, MarkerPoseParams().same_pose_deg * M_PI / 180.0);
}

TEST(MarkerLocalizer, LeavesOutAMarkerThatWasMoved) {
  Random random(500025);
  const Pose2 truth{1.2, 0.1, 0.0};
  MarkerMap moved = wallMap();
  moved.markers.at(1).map_from_marker.translation().y() += 0.3;
  const MarkerFix fix = localizer(wallMap()).locate(seen(moved, test::bentCamera(), truth, 0.1, random));
  ASSERT_TRUE(fix.isGood()) << toText(fix.status);
  EXPECT_LT(difference(fix.map_from_base, truth).norm(), 0.03);
  for (const MarkerSighting& sighting : fix.sightings)
    EXPECT_EQ(sighting.use, sighting.corners.id == 1 ? Use::kInconsistent : Use::kUsed)
        << sighting.corners.id;
}

TEST(MarkerLocalizer, DoesNotChooseBetweenTwoThatContradictEachOther) {
  Random random(500026);
  const Pose2 truth{1.2, 0.1, 0.0};
  MarkerMap moved = only({0, 1});
  moved.markers.at(1).map_from_marker.translation().y() += 0.3;
  EXPECT_EQ(localizer(only({0, 1})).locate(seen(moved, test::bentCamera(), truth, 0.1, random)).status,
            Status::kInconsistent);
}

// A marker of 0.15 m where the map says 0.20 m: it looks a third farther away and, well above the camera, a
// third higher, which puts the robot under the floor.
TEST(MarkerLocalizer, RefusesAMarkerOfTheWrongSize) {
  Random random(500027);
  const Pose2 truth{2.0, -0.5, 0.0};
  MarkerMap printed = only({1});
  printed.markers.at(1).size_m = 0.15;
  const MarkerFix fix =
      localizer(only({1})).locate(seen(printed, test::bentCamera(), truth, 0.1, random), truth);
  EXPECT_EQ(fix.status, Status::kOffFloor);
}

TEST(MarkerLocalizer, UsesNeitherUnknownMarkersNorIdsThatAreThereTwice) {
  Random random(500028);
  const Pose2 truth{1.2, 0.1, 0.0};
  auto corners = seen(only({0, 1}), test::bentCamera(), truth, 0.1, random);
  corners[1].id = 0;
  const MarkerFix twice = localizer(wallMap()).locate(corners);
  EXPECT_EQ(twice.status, Status::kNoMarker);
  EXPECT_EQ(twice.sightings[0].use, Use::kTwice);
  EXPECT_EQ(twice.sightings[1].use, Use::kTwice);
  corners[0].id = 40;
  const MarkerFix unknown = localizer(wallMap()).locate({corners[0]});
  EXPECT_EQ(unknown.status, Status::kNoMarker);
  EXPECT_EQ(unknown.sightings[0].use, Use::kUnmapped);
  EXPECT_EQ(localizer(wallMap()).locate({}).status, Status::kNoMarker);
}

}  // namespace
}  // namespace frugal_nav
