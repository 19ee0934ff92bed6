#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <frugal_nav/perception/closer_look.hpp>

namespace frugal_nav {
namespace {

const cv::Size kImage(400, 300);

/// Gives the same boxes for every image, and keeps what it was shown.
class FixedDetector : public Detector {
 public:
  std::vector<Detection> detect(const cv::Mat& bgr) override {
    sizes.push_back(bgr.size());
    return boxes;
  }

  std::vector<Detection> boxes;
  std::vector<cv::Size> sizes;
};

CloserLookParams halves() {
  CloserLookParams params;
  params.share = 0.6;
  return params;
}

TEST(CloserLook, CoversTheWidthAtTheGivenRow) {
  const std::vector<cv::Rect> parts = CloserLook(halves()).across(kImage, 150.0);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0], cv::Rect(0, 60, 240, 180));
  EXPECT_EQ(parts[1], cv::Rect(160, 60, 240, 180));
}

TEST(CloserLook, StaysWithinTheImage) {
  const CloserLook look(halves());
  EXPECT_EQ(look.across(kImage, -1000.0)[0], cv::Rect(0, 0, 240, 180));
  EXPECT_EQ(look.across(kImage, 1000.0)[1], cv::Rect(160, 120, 240, 180));
  EXPECT_EQ(look.around(kImage, {399.0, 299.0}), cv::Rect(160, 120, 240, 180));
  EXPECT_EQ(look.around(kImage, {200.0, 150.0}), cv::Rect(80, 60, 240, 180));
}

TEST(CloserLook, GivesBoxesInTheWholeImage) {
  FixedDetector detector;
  detector.boxes = {{0, "head", 0.7, {100.0, 50.0, 10.0, 12.0}}};
  const auto found = CloserLook::add({}, cv::Mat(kImage, CV_8UC3), {cv::Rect(160, 60, 240, 180)}, detector);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].box, cv::Rect2d(260.0, 110.0, 10.0, 12.0));
  ASSERT_EQ(detector.sizes.size(), 1U);
  EXPECT_EQ(detector.sizes[0], cv::Size(240, 180));
}

TEST(CloserLook, KeepsTheBetterBoxOfOneThing) {
  FixedDetector detector;
  detector.boxes = {{0, "head", 0.8, {100.0, 50.0, 10.0, 12.0}}};
  const std::vector<Detection> whole = {{0, "head", 0.4, {100.0, 50.0, 12.0, 14.0}},
                                        {0, "head", 0.6, {300.0, 50.0, 12.0, 14.0}}};
  const auto found = CloserLook::add(whole, cv::Mat(kImage, CV_8UC3), {cv::Rect(0, 0, 240, 180)}, detector);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].box, cv::Rect2d(100.0, 50.0, 10.0, 12.0));
  EXPECT_EQ(found[1].score, 0.6);
}

// The right edge of the left part cuts what stands there; the image's own edge is left to those who range it.
TEST(CloserLook, LeavesOutWhatAPartCuts) {
  FixedDetector detector;
  detector.boxes = {{0, "head", 0.8, {230.0, 50.0, 10.0, 12.0}}, {0, "head", 0.7, {0.0, 50.0, 10.0, 12.0}}};
  const auto found = CloserLook::add({}, cv::Mat(kImage, CV_8UC3), {cv::Rect(0, 0, 240, 180)}, detector);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].score, 0.7);
}

// Half a person in a part of the image, surer than the whole one, is no second person; a small one before a
// doubtful large one is.
TEST(CloserLook, LeavesOutAPieceOfWhatTheWholeImageShows) {
  FixedDetector detector;
  detector.boxes = {{0, "person", 0.9, {60.0, 20.0, 60.0, 100.0}}};
  std::vector<Detection> whole = {{0, "person", 0.6, {40.0, 10.0, 100.0, 270.0}}};
  const cv::Mat image(kImage, CV_8UC3);
  const std::vector<cv::Rect> parts = {cv::Rect(0, 0, 240, 180)};
  ASSERT_EQ(CloserLook::add(whole, image, parts, detector).size(), 1U);
  EXPECT_EQ(CloserLook::add(whole, image, parts, detector)[0].box.height, 270.0);
  whole[0].score = 0.3;
  EXPECT_EQ(CloserLook::add(whole, image, parts, detector).size(), 2U);
}

TEST(CloserLook, RefusesASmallShare) {
  CloserLookParams params;
  params.share = 0.4;
  EXPECT_THROW(CloserLook{params}, ConfigError);
}

}  // namespace
}  // namespace frugal_nav
