#include "marker_view.hpp"

#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <support/shared_data.hpp>

#include <frugal_nav/perception/marker_detector.hpp>

namespace frugal_nav {
namespace {

using test::facingCamera;
using test::MarkerLight;
using test::straightCamera;
using test::viewOf;

const MarkerDictionary& fourByFour() {
  static const MarkerDictionary kDictionary("DICT_4X4_50");
  return kDictionary;
}

TEST(MarkerDictionary, RefusesAnUnknownNameWithTheKnownOnes) {
  try {
    MarkerDictionary("4x4");
    FAIL() << "an unknown dictionary was taken";
  } catch (const ConfigError& error) {
    for (const std::string& name : MarkerDictionary::names())
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << name;
  }
}

TEST(MarkerDictionary, KnowsEachOfItsNames) {
  for (const std::string& name : MarkerDictionary::names()) {
    const MarkerDictionary dictionary(name);
    EXPECT_GE(dictionary.count(), 30) << name;
    EXPECT_EQ(dictionary.cellsOf(0).rows, dictionary.cells()) << name;
  }
  EXPECT_EQ(fourByFour().count(), 50);
  EXPECT_EQ(fourByFour().cells(), 6);
  EXPECT_EQ(MarkerDictionary("DICT_7X7_250").count(), 250);
  EXPECT_EQ(MarkerDictionary("DICT_APRILTAG_36h11").count(), 587);
}

TEST(MarkerDetector, FindsAMarkerOfEachDictionaryUnderItsName) {
  for (const std::string& name : MarkerDictionary::names()) {
    Random random(500001);
    MarkerDetectorParams params;
    params.dictionary = name;
    const cv::Mat image = viewOf(MarkerDictionary(name), 7, 0.2, straightCamera(),
                                 facingCamera({0.1, -0.05, 1.0}, 0.4), MarkerLight(), random);
    const MarkerFindings found = MarkerDetector(params).detect(image);
    ASSERT_EQ(found.markers.size(), 1U) << name;
    EXPECT_EQ(found.markers[0].id, 7) << name;
  }
}

// Corners of a blurred, noisy print, 20 poses. A marker must not look larger or smaller: 0.08 px outward at
// each corner of a marker of 50 px are 0.2 % of its distance.
TEST(MarkerDetector, PutsCornersWithinATenthOfAPixel) {
  Random random(500002);
  MarkerLight light;
  light.noise = 5.0;
  const MarkerDetector detector{MarkerDetectorParams()};
  double sum_px = 0.0;
  Eigen::Vector2d bias(0.0, 0.0);
  double outward_px = 0.0;
  int corners = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d centre(random.uniform(-0.3, 0.3), random.uniform(-0.25, 0.25),
                                 random.uniform(0.8, 2.0));
    const Eigen::Isometry3d pose = facingCamera(centre, random.uniform(-0.8, 0.8), random.uniform(-0.4, 0.4),
                                                random.uniform(-M_PI, M_PI));
    const int id = random.integer(0, 49);
    const cv::Mat image = viewOf(fourByFour(), id, 0.2, straightCamera(), pose, light, random);
    const MarkerFindings found = detector.detect(image);
    ASSERT_EQ(found.markers.size(), 1U) << "trial " << trial;
    EXPECT_EQ(found.markers[0].id, id);
    for (std::size_t i = 0; i < 4; ++i, ++corners) {
      const Eigen::Vector2d off =
          found.markers[0].pixels[i] - *straightCamera().project(pose * markerCorners(0.2)[i]);
      sum_px += off.norm();
      bias += off;
      outward_px += off.dot((found.markers[0].pixels[i] - *straightCamera().project(centre)).normalized());
    }
  }
  EXPECT_LT(sum_px / corners, 0.1);
  EXPECT_LT(std::abs(outward_px / corners), 0.08);
  EXPECT_LT((bias / corners).norm(), 0.03);
}

TEST(MarkerDetector, TellsWhetherTheWhiteIsOverexposed) {
  Random random(500006);
  MarkerLight light;
  const auto isClipped = [&]() {
    const cv::Mat image =
        viewOf(fourByFour(), 5, 0.2, straightCamera(), facingCamera({0.0, 0.0, 1.0}, 0.3), light, random);
    const MarkerFindings found = MarkerDetector(MarkerDetectorParams()).detect(image);
    return !found.markers.empty() && found.markers[0].is_clipped;
  };
  EXPECT_FALSE(isClipped());
  light.white = 400.0;
  EXPECT_TRUE(isClipped());
}

TEST(MarkerDetector, GivesOutOnlyWhatIsOnTheWhitelist) {
  Random random(500003);
  const Pinhole camera = straightCamera();
  const MarkerLight light;
  cv::Mat drawing(camera.height_px, camera.width_px, CV_32FC1, cv::Scalar(light.wall));
  drawMarker(fourByFour(), 3, 0.2, camera, facingCamera({-0.3, 0.0, 1.2}, 0.0), light, drawing);
  drawMarker(fourByFour(), 8, 0.2, camera, facingCamera({0.3, 0.0, 1.2}, 0.0), light, drawing);
  const cv::Mat image = test::expose(drawing, light, random);
  EXPECT_EQ(MarkerDetector(MarkerDetectorParams()).detect(image).markers.size(), 2U);
  const MarkerFindings found = MarkerDetector(MarkerDetectorParams(), {8, 9}).detect(image);
  ASSERT_EQ(found.markers.size(), 1U);
  EXPECT_EQ(found.markers[0].id, 8);
  EXPECT_EQ(found.unlisted_ids, std::vector<int>{3});
}

TEST(MarkerDetector, RefusesAWhitelistedIdThatItsDictionaryLacks) {
  EXPECT_THROW(MarkerDetector(MarkerDetectorParams(), {50}), ConfigError);
  EXPECT_THROW(MarkerDetector(MarkerDetectorParams(), {-1}), ConfigError);
}

TEST(MarkerDetector, GivesAnIdTwiceWhenItIsThereTwice) {
  Random random(500004);
  const Pinhole camera = straightCamera();
  const MarkerLight light;
  cv::Mat drawing(camera.height_px, camera.width_px, CV_32FC1, cv::Scalar(light.wall));
  for (const double x : {-0.3, 0.3})
    drawMarker(fourByFour(), 3, 0.2, camera, facingCamera({x, 0.0, 1.2}, 0.0), light, drawing);
  const MarkerFindings found =
      MarkerDetector(MarkerDetectorParams()).detect(test::expose(drawing, light, random));
  ASSERT_EQ(found.markers.size(), 2U);
  EXPECT_EQ(found.markers[0].id, 3);
  EXPECT_EQ(found.markers[1].id, 3);
}

TEST(MarkerDetector, NamesAnImageItCannotSearch) {
  const MarkerDetector detector{MarkerDetectorParams()};
  EXPECT_NE(detector.detect(cv::Mat()).fault, "");
  EXPECT_NE(detector.detect(cv::Mat(480, 640, CV_16UC1, cv::Scalar(0))).fault, "");
  EXPECT_EQ(detector.detect(cv::Mat(480, 640, CV_8UC3, cv::Scalar(0, 0, 0))).fault, "");
}

TEST(MarkerDetector, FindsNothingInNoise) {
  Random random(500005);
  MarkerLight light;
  light.noise = 60.0;
  const MarkerDetector detector{MarkerDetectorParams()};
  for (int trial = 0; trial < 10; ++trial) {
    const cv::Mat image = test::expose(cv::Mat(480, 640, CV_32FC1, cv::Scalar(120.0)), light, random);
    EXPECT_TRUE(detector.detect(image).markers.empty());
  }
}

// OpenCV's tutorial names the markers of its photograph: 40, 98, 62, 23, 124 and 203 of DICT_6X6_250.
TEST(MarkerDetector, FindsTheMarkersOfAPhotograph) {
  const std::string path = test::sharedFile("aruco/singlemarkersoriginal.jpg");
  if (path.empty())
    GTEST_SKIP() << "needs the photograph aruco/singlemarkersoriginal.jpg beside the source tree";
  MarkerDetectorParams params;
  params.dictionary = "DICT_6X6_250";
  const cv::Mat image = cv::imread(path);
  ASSERT_FALSE(image.empty());
  std::vector<int> ids;
  for (const MarkerCorners& marker : MarkerDetector(params).detect(image).markers) ids.push_back(marker.id);
  EXPECT_EQ(ids, (std::vector<int>{23, 40, 62, 98, 124, 203}));
}

}  // namespace
}  // namespace frugal_nav
