#include "../perception/marker_view.hpp"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <frugal_nav/localization/marker_localization.hpp>

namespace frugal_nav {
namespace {

using State = LocalizationStatus::State;
using test::bentCamera;
using test::cameraAt;
using test::mounted;
using test::seen;
using test::wallMap;
using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const Pose2 kMapFromOdom{1.0, 0.4, 0.1};
const Pose2 kStart = kMapFromOdom;  // the odometry begins at zero

Stamp at(double seconds) { return stampFromSeconds(100.0 + seconds); }

MarkerCamera camera(Stamp stamp) { return {stamp, bentCamera(), mounted()}; }

MarkerFindings findings(const Pose2& map_from_base, const MarkerMap& map = wallMap()) {
  Random random(500001);
  MarkerFindings found;
  found.markers = seen(map, bentCamera(), map_from_base, 0.1, random);
  return found;
}

/// The robot drives a gentle arc from kStart.
const Twist2 kTwist{0.2, 0.1};
Pose2 odomAt(double seconds) { return arcMotion(kTwist, seconds); }
Pose2 truthAt(double seconds) { return kMapFromOdom * odomAt(seconds); }

struct Drive {
  MarkerLocalization localization{MarkerLocalizationParams{}, wallMap()};
  std::optional<MapPose> last;
  int poses = 0;

  /// Odometry at 50 Hz and gyro at 100 Hz, each as it comes.
  void run(double from_s, double to_s, bool with_odometry = true, bool with_gyro = true) {
    const int last_tick = static_cast<int>(std::lround(100.0 * to_s));
    for (int i = static_cast<int>(std::lround(100.0 * from_s)); i < last_tick; ++i) {
      const Stamp now = at(0.01 * i);
      if (with_gyro) localization.addGyro(now, kTwist.w_radps, now);
      if (with_odometry && i % 2 == 0) add(0.01 * i);
    }
  }
  void add(double seconds) {
    Odometry odometry;
    odometry.stamp = at(seconds);
    odometry.odom_from_base = odomAt(seconds);
    odometry.twist = kTwist;
    const auto pose = localization.addOdometry(odometry, odometry.stamp).pose;
    if (!pose) return;
    last = pose;
    ++poses;
  }
  MarkerImageResult look(double seconds, double received_s) {
    return localization.addCorners(camera(at(seconds)), findings(truthAt(seconds)), at(received_s));
  }
};

// A fit over four markers with 0.1 px of noise errs by a few millimetres and a few mrad.
void expectNear(const Pose2& found, const Pose2& truth) {
  EXPECT_LT(distance(found, truth), 0.02);
  EXPECT_NEAR(angleBetween(found.yaw_rad, truth.yaw_rad), 0.0, 0.01);
}

TEST(MarkerLocalization, TellsNothingBeforeTheFirstMarker) {
  Drive drive;
  drive.run(0.0, 0.5);
  EXPECT_EQ(drive.poses, 0);
  EXPECT_EQ(drive.localization.status(at(0.5)).state, State::kNoFix);
  EXPECT_THAT(drive.localization.status(at(0.5)).reason, HasSubstr("no fix yet"));
  const MarkerImageResult image = drive.look(0.5, 0.5);
  EXPECT_TRUE(image.isUsed());
  drive.run(0.5, 1.0);
  ASSERT_TRUE(drive.last);
  EXPECT_EQ(drive.poses, 25);
  expectNear(drive.last->estimate.map_from_base, truthAt(0.98));
  expectNear(drive.last->map_from_odom, kMapFromOdom);
  EXPECT_TRUE(drive.localization.status(at(1.0)).isSound());
}

TEST(MarkerLocalization, GivesEachStampOnce) {
  Drive drive;
  drive.look(0.0, 0.0);
  drive.run(0.0, 0.5);
  const int poses = drive.poses;
  drive.add(0.48);  // the last one again
  drive.add(0.30);  // and one out of order
  EXPECT_EQ(drive.poses, poses);
}

TEST(MarkerLocalization, ALateImageCountsAtItsOwnStamp) {
  Drive in_time;
  in_time.look(0.0, 0.0);
  in_time.run(0.0, 0.5);
  in_time.look(0.5, 0.5);
  in_time.run(0.5, 1.0);
  Drive late;
  late.look(0.0, 0.0);
  late.run(0.0, 0.8);
  const std::uint64_t replayed = late.localization.counts().late;
  EXPECT_TRUE(late.look(0.5, 0.8).isUsed());
  EXPECT_EQ(late.localization.counts().late, replayed + 1);
  late.run(0.8, 1.0);
  // The prediction that the fit starts from differs in nothing: the same measurements in another order.
  EXPECT_LT(distance(late.last->estimate.map_from_base, in_time.last->estimate.map_from_base), 1e-6);
}

TEST(MarkerLocalization, SaysOfEachMarkerWhyItWasRefused) {
  Drive drive;
  MarkerFindings found = findings(kStart);
  MarkerCorners spurious = found.markers[0];
  spurious.id = 17;
  found.markers.push_back(spurious);
  found.markers.push_back(found.markers[1]);
  found.unlisted_ids = {23};
  const MarkerImageResult image = drive.localization.addCorners(camera(at(0.0)), found, at(0.0));
  ASSERT_TRUE(image.isUsed());
  EXPECT_EQ(image.unlisted_ids, std::vector<int>{23});
  int accepted = 0;
  for (const MarkerSighting& sighting : image.fix.sightings) {
    const int id = sighting.corners.id;
    EXPECT_EQ(image.isAccepted(sighting), id == 0 || id == 2 || id == 3) << id;
    accepted += image.isAccepted(sighting);
    if (id == 1) {
      EXPECT_EQ(image.reason(sighting), toText(MarkerSighting::Use::kTwice));
    } else if (id == 17) {
      EXPECT_EQ(image.reason(sighting), toText(MarkerSighting::Use::kUnmapped));
    } else {
      EXPECT_EQ(image.reason(sighting), "used");
    }
  }
  EXPECT_EQ(accepted, 3);
}

TEST(MarkerLocalization, AMarkerOfTheWrongSizeMovesNothing) {
  Drive drive;
  drive.look(0.0, 0.0);
  drive.run(0.0, 0.2);
  MarkerMap as_it_hangs;
  as_it_hangs.markers[0] = wallMap().markers.at(0);
  as_it_hangs.markers[0].size_m = 0.10;  // half of what the map says: the robot seems twice as far away
  const MarkerImageResult image =
      drive.localization.addCorners(camera(at(0.2)), findings(truthAt(0.2), as_it_hangs), at(0.2));
  ASSERT_EQ(image.fix.sightings.size(), 1u);
  EXPECT_FALSE(image.isAccepted(image.fix.sightings[0]));
  EXPECT_FALSE(image.reason(image.fix.sightings[0]).empty());
  drive.run(0.2, 0.3);
  expectNear(drive.last->map_from_odom, kMapFromOdom);
}

TEST(MarkerLocalization, AFixFarOffIsGated) {
  Drive drive;
  drive.look(0.0, 0.0);
  drive.run(0.0, 0.2);
  const MarkerImageResult image =
      drive.localization.addCorners(camera(at(0.2)), findings({1.6, -0.3, 0.0}), at(0.2));
  EXPECT_EQ(image.filter, FilterStatus::kGated);
  EXPECT_EQ(image.reason(image.fix.sightings.at(0)), toText(FilterStatus::kGated));
}

TEST(MarkerLocalization, RefusesImagesFromTheFutureAndFromBeforeTheHistory) {
  Drive drive;
  drive.look(0.0, 0.0);
  drive.run(0.0, 4.0);
  EXPECT_EQ(drive.look(9.0, 4.0).reason(), toText(FilterStatus::kFromFuture));
  EXPECT_EQ(drive.look(0.5, 4.0).reason(), toText(FilterStatus::kTooOld));
  drive.run(4.0, 4.1);
  expectNear(drive.last->map_from_odom, kMapFromOdom);
}

TEST(MarkerLocalization, RefusesACameraWithoutCalibration) {
  Drive drive;
  MarkerCamera taken = camera(at(0.0));
  taken.camera = Pinhole{};
  const MarkerImageResult image = drive.localization.addCorners(taken, findings(kStart), at(0.0));
  EXPECT_FALSE(image.reason().empty());
  EXPECT_EQ(image.reason(), taken.camera.fault());
  taken = camera(at(0.0));
  taken.base_from_optical.translation().x() = kNan;
  EXPECT_THAT(drive.localization.addCorners(taken, findings(kStart), at(0.0)).reason(), HasSubstr("finite"));
  EXPECT_FALSE(drive.localization.estimate());
}

TEST(MarkerLocalization, SwitchedOffMarkersAreLookedAtButNotUsed) {
  Drive drive;
  drive.look(0.0, 0.0);
  drive.localization.setEnabled(FilterInput::kPose, false);
  drive.run(0.0, 2.0);
  const MarkerImageResult image = drive.look(2.0, 2.0);
  EXPECT_EQ(image.fix.sightings.size(), 4u);
  EXPECT_EQ(image.reason(), toText(FilterStatus::kDisabled));
  EXPECT_EQ(drive.localization.status(at(2.0)).state, State::kWithoutMarkers);
}

TEST(MarkerLocalization, GoesOnWithoutGyroOrOdometryAndSaysSo) {
  Drive drive;
  drive.look(0.0, 0.0);
  drive.run(0.0, 1.0);
  drive.run(1.0, 1.5, true, false);
  EXPECT_THAT(drive.localization.status(at(1.5)).reason, HasSubstr("gyro silent"));
  expectNear(drive.last->map_from_odom, kMapFromOdom);
  drive.run(1.5, 2.0, false, true);
  EXPECT_THAT(drive.localization.status(at(2.0)).reason, HasSubstr("twist silent"));
  EXPECT_TRUE(drive.look(2.0, 2.0).isUsed());  // where it is then is the markers' word
  const auto pose = drive.localization.poseWithoutOdometry(at(2.0));
  ASSERT_TRUE(pose);
  expectNear(pose->map_from_base, truthAt(2.0));
  EXPECT_FALSE(drive.localization.poseWithoutOdometry(at(2.0))) << "each stamp once";
  drive.run(2.0, 2.1);
  EXPECT_FALSE(drive.localization.poseWithoutOdometry(at(2.15))) << "odometry is back";
}

TEST(MarkerLocalization, AGapOfFiveSecondsIsSurvivedAndFeltInTheCovariance) {
  Drive drive;
  drive.look(0.0, 0.0);
  drive.run(0.0, 1.0);
  const LocalizationStatus lost = drive.localization.status(at(6.0));
  EXPECT_EQ(lost.state, State::kLost);
  EXPECT_THAT(lost.reason, HasSubstr("neither twist nor gyro"));
  drive.run(6.0, 6.1);
  EXPECT_TRUE(drive.look(6.1, 6.1).isUsed());
  drive.run(6.1, 6.3);
  expectNear(drive.last->estimate.map_from_base, truthAt(6.28));
  expectNear(drive.last->map_from_odom, kMapFromOdom);
}

// A lone small marker far ahead looks nearly alike from two places. After a gap nobody knows the heading, and
// the prediction must not decide.
TEST(MarkerLocalization, AnUncertainPredictionDoesNotChooseBetweenTwoPlaces) {
  MarkerMap lone;
  lone.markers[2] = wallMap().markers.at(2);
  Random random(500006);
  int chosen = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const double y = random.uniform(-1.0, 1.0);
    const Pose2 truth{1.0, y, std::atan2(0.1 - y, 3.0)};
    MarkerFindings found;
    found.markers = seen(lone, bentCamera(), truth, 0.3, random);
    const auto statusAfter = [&](double gap_s) {
      MarkerLocalization localization{MarkerLocalizationParams{}, lone};
      PoseFix fix;
      fix.map_from_base = truth;
      fix.covariance.diagonal().setConstant(1e-4);
      localization.setPose(at(0.0), fix, at(0.0));
      return localization.addCorners(camera(at(gap_s)), found, at(gap_s)).fix.status;
    };
    MarkerLocalization alone{MarkerLocalizationParams{}, lone};
    if (alone.addCorners(camera(at(0.0)), found, at(0.0)).fix.status != MarkerFix::Status::kAmbiguous)
      continue;
    chosen += statusAfter(0.02) == MarkerFix::Status::kGood;
    EXPECT_EQ(statusAfter(5.0), MarkerFix::Status::kAmbiguous) << "trial " << trial;
  }
  EXPECT_GT(chosen, 5);
}

TEST(MarkerLocalization, SaysWhatBecameOfAnOdometry) {
  Drive drive;
  drive.look(0.0, 0.0);
  drive.run(0.0, 4.0);
  Odometry odometry;
  odometry.stamp = at(9.0);
  EXPECT_EQ(drive.localization.addOdometry(odometry, at(4.0)).filter, FilterStatus::kFromFuture);
  odometry.stamp = at(0.5);
  EXPECT_EQ(drive.localization.addOdometry(odometry, at(4.0)).filter, FilterStatus::kTooOld);
  drive.localization.setEnabled(FilterInput::kEncoders, false);
  odometry.stamp = at(4.0);
  const OdometryResult result = drive.localization.addOdometry(odometry, at(4.0));
  EXPECT_EQ(result.filter, FilterStatus::kDisabled);
  EXPECT_TRUE(result.pose);
}

TEST(MarkerLocalization, NumbersThatAreNoneAreCountedAndDropped) {
  Drive drive;
  drive.look(0.0, 0.0);
  drive.run(0.0, 0.5);
  EXPECT_EQ(drive.localization.addGyro(at(0.5), kNan, at(0.5)), FilterStatus::kNotFinite);
  Odometry odometry;
  odometry.stamp = at(0.5);
  odometry.twist.v_mps = kNan;
  EXPECT_TRUE(drive.localization.addOdometry(odometry, at(0.5)).pose);  // which is sound
  odometry.odom_from_base.x_m = kNan;
  odometry.stamp = at(0.52);
  EXPECT_EQ(drive.localization.addOdometry(odometry, at(0.52)).filter, FilterStatus::kNotFinite);
  const PoseFilterCounts& counts = drive.localization.counts();
  EXPECT_EQ(counts.of(FilterInput::kGyro, FilterStatus::kNotFinite), 1u);
  EXPECT_EQ(counts.of(FilterInput::kEncoders, FilterStatus::kNotFinite), 1u);
}

TEST(MarkerLocalization, AJumpBackInTimeStartsAnew) {
  Drive drive;
  drive.look(2.0, 2.0);
  drive.run(2.0, 3.0);
  const int poses = drive.poses;
  ASSERT_GT(poses, 40);
  drive.run(0.0, 0.5);
  EXPECT_EQ(drive.poses, poses);
  EXPECT_EQ(drive.localization.status(at(0.5)).state, State::kNoFix);
  EXPECT_EQ(drive.localization.counts().time_jumps, 1u);
  drive.look(0.5, 0.5);
  drive.run(0.5, 0.6);
  EXPECT_EQ(drive.poses, poses + 5);
  drive.localization.reset();
  EXPECT_FALSE(drive.localization.estimate());
}

TEST(MarkerLocalization, TakesThePoseItIsGiven) {
  Drive drive;
  drive.run(0.0, 0.5);
  PoseFix fix;
  fix.map_from_base = truthAt(0.5);
  fix.covariance = Eigen::Vector3d(0.01, 0.01, 0.01).asDiagonal();
  EXPECT_EQ(drive.localization.setPose(at(0.5), fix, at(0.5)), FilterStatus::kUsed);
  drive.run(0.5, 0.6);
  expectNear(drive.last->map_from_odom, kMapFromOdom);
  EXPECT_EQ(drive.localization.status(at(0.6)).state, State::kWithoutMarkers) << "none was seen";
  fix.covariance(0, 0) = -1.0;
  EXPECT_EQ(drive.localization.setPose(at(0.6), fix, at(0.6)), FilterStatus::kBadCovariance);
}

TEST(MarkerLocalization, DrivesByTheCommandedSpeedToo) {
  MarkerLocalizationParams params;
  params.filter.twist_source = "command";
  MarkerLocalization localization(params, wallMap());
  localization.addCorners(camera(at(0.0)), findings(kStart), at(0.0));
  for (int i = 0; i < 20; ++i) localization.addCommand(at(0.05 * i), kTwist, at(0.05 * i));
  Odometry odometry;  // its own twist does not count
  odometry.stamp = at(1.0);
  odometry.odom_from_base = odomAt(1.0);
  const auto pose = localization.addOdometry(odometry, at(1.0)).pose;
  ASSERT_TRUE(pose);
  expectNear(pose->estimate.map_from_base, truthAt(1.0));
  expectNear(pose->map_from_odom, kMapFromOdom);
}

TEST(MarkerLocalization, FindsTheMarkersInAPicture) {
  Drive drive;
  Random random(500002);
  const MarkerMap map = wallMap();
  const cv::Mat image = test::viewOf(map, bentCamera(), cameraAt(kStart), test::MarkerLight{}, random);
  ASSERT_TRUE(drive.localization.addImage(camera(at(0.0)), image, at(0.0)).isUsed());
  expectNear(drive.localization.estimate()->map_from_base, kStart);
  const MarkerImageResult nothing =
      drive.localization.addImage(camera(at(0.1)), cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(90)), at(0.1));
  EXPECT_EQ(nothing.reason(), toText(MarkerFix::Status::kNoMarker));
  EXPECT_TRUE(nothing.fix.sightings.empty());
}

TEST(MarkerLocalization, FollowsACameraThatIsCalibratedAnew) {
  Drive drive;
  EXPECT_TRUE(drive.look(0.0, 0.0).isUsed());
  MarkerCamera other = camera(at(0.1));
  other.camera = test::straightCamera();
  Random random(500003);
  MarkerFindings found;
  found.markers = seen(wallMap(), other.camera, kStart, 0.1, random);
  const MarkerImageResult image = drive.localization.addCorners(other, found, at(0.1));
  EXPECT_LT(image.fix.image_error_px, 0.5);
  expectNear(image.fix.map_from_base, kStart);
}

// A robot that speeds up by 0.3 m/s^2 with a twist that is a mean over its last 80 ms, 40 ms late: by it the
// way of a second is 12 mm short.
TEST(MarkerLocalization, MovesByTheWayOfTheOdometryNotByItsSmoothedTwist) {
  MarkerLocalization localization(MarkerLocalizationParams{}, wallMap());
  PoseFix start;
  start.covariance.diagonal().setConstant(1e-6);
  localization.setPose(at(0.0), start, at(0.0));
  constexpr double kAcceleration = 0.3;
  for (int i = 0; i <= 50; ++i) {
    const double t = 0.02 * i;
    Odometry odometry;
    odometry.stamp = at(t);
    odometry.odom_from_base.x_m = 0.5 * kAcceleration * t * t;
    odometry.twist.v_mps = kAcceleration * std::max(0.0, t - 0.04);
    localization.addOdometry(odometry, at(t));
  }
  // What is left: the mean of two intervals is taken for each, half an interval late.
  EXPECT_NEAR(localization.estimate()->map_from_base.x_m, 0.5 * kAcceleration, 0.004);
}

TEST(MarkerLocalization, AJumpOfTheOdometryMovesNothing) {
  for (const Pose2& jump : {Pose2{0.5, 0.0, 0.0}, Pose2{0.0, 0.0, 0.5}}) {
    MarkerLocalization localization(MarkerLocalizationParams{}, wallMap());
    PoseFix start;
    start.covariance.diagonal().setConstant(1e-6);
    localization.setPose(at(0.0), start, at(0.0));
    for (int i = 0; i <= 10; ++i) {
      Odometry odometry;
      odometry.stamp = at(0.02 * i);
      if (i > 5) odometry.odom_from_base = jump;
      localization.addOdometry(odometry, odometry.stamp);
    }
    const Pose2 pose = localization.estimate()->map_from_base;
    EXPECT_LT(pose.position().norm(), 1e-6);
    EXPECT_LT(std::abs(pose.yaw_rad), 1e-6);
  }
}

TEST(MarkerLocalization, RefusesContradictingConfiguration) {
  MarkerLocalizationParams params;
  params.detector.dictionary = "DICT_5X5_50";
  try {
    MarkerLocalization localization(params, wallMap());
    FAIL() << "two dictionaries";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("DICT_5X5_50"));
    EXPECT_THAT(error.what(), HasSubstr("DICT_4X4_50"));
  }
  params = {};
  MarkerLocalization localization(params, wallMap());
  params.max_sigma_m = -1.0;
  EXPECT_THROW(localization.setParams(params), ConfigError);
  params.max_sigma_m = 0.2;
  EXPECT_NO_THROW(localization.setParams(params));
}

}  // namespace
}  // namespace frugal_nav
