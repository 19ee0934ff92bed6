#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/perception/letterbox.hpp>

namespace frugal_nav {
namespace {

TEST(Letterbox, PadsEvenlyWithGrey) {
  // 640x480 into 416x416: scale 0.65, content 416x312, 52 rows above and below.
  const cv::Mat image(480, 640, CV_8UC3, cv::Scalar(10, 20, 30));
  const cv::Mat input = Letterbox({640, 480}, {416, 416}, Fit::kLetterbox).apply(image);
  ASSERT_EQ(input.size(), cv::Size(416, 416));
  EXPECT_EQ(input.at<cv::Vec3b>(51, 200), cv::Vec3b(114, 114, 114));
  EXPECT_EQ(input.at<cv::Vec3b>(52, 200), cv::Vec3b(10, 20, 30));
  EXPECT_EQ(input.at<cv::Vec3b>(363, 200), cv::Vec3b(10, 20, 30));
  EXPECT_EQ(input.at<cv::Vec3b>(364, 200), cv::Vec3b(114, 114, 114));
}

TEST(Letterbox, PadsBelowInTheCorner) {
  const cv::Mat image(480, 640, CV_8UC3, cv::Scalar(10, 20, 30));
  const cv::Mat input = Letterbox({640, 480}, {416, 416}, Fit::kCorner).apply(image);
  EXPECT_EQ(input.at<cv::Vec3b>(0, 0), cv::Vec3b(10, 20, 30));
  EXPECT_EQ(input.at<cv::Vec3b>(311, 415), cv::Vec3b(10, 20, 30));
  EXPECT_EQ(input.at<cv::Vec3b>(312, 0), cv::Vec3b(114, 114, 114));
}

TEST(Letterbox, GivesBoxesBackInTheImage) {
  const Letterbox letterbox({640, 480}, {416, 416}, Fit::kLetterbox);
  const cv::Rect2d box = letterbox.toImage({65.0, 52.0 + 130.0, 13.0, 26.0});
  EXPECT_NEAR(box.x, 100.0, 1e-9);
  EXPECT_NEAR(box.y, 200.0, 1e-9);
  EXPECT_NEAR(box.width, 20.0, 1e-9);
  EXPECT_NEAR(box.height, 40.0, 1e-9);
}

TEST(Letterbox, UndoesItselfForAnySize) {
  Random random(500001);
  for (int i = 0; i < 500; ++i) {
    const cv::Size image(random.integer(17, 1999), random.integer(17, 1999));
    const cv::Size input(32 * random.integer(5, 20), 32 * random.integer(5, 20));
    for (const Fit fit : {Fit::kLetterbox, Fit::kCorner, Fit::kStretch}) {
      const Letterbox letterbox(image, input, fit);
      const cv::Rect2d box(random.uniform(0, image.width), random.uniform(0, image.height),
                           random.uniform(1, image.width), random.uniform(1, image.height));
      const cv::Rect2d back = letterbox.toImage(letterbox.toInput(box));
      EXPECT_NEAR(back.x, box.x, 1e-6);
      EXPECT_NEAR(back.y, box.y, 1e-6);
      EXPECT_NEAR(back.width, box.width, 1e-6);
      EXPECT_NEAR(back.height, box.height, 1e-6);
    }
  }
}

// The mapping is that of the pixels, not only its own inverse: a smooth spot's centroid goes where toInput
// says. 641x479 into 320x320: the wanted scale gives 239.13 rows, the image gets 239: off by 0.1 px with the
// former.
TEST(Letterbox, MapsBoxesAsItMapsPixels) {
  const cv::Point2d spot(430.5, 400.5);  // of pixel (430, 400), from the image's edge
  cv::Mat image(479, 641, CV_32F);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double r = std::hypot(x + 0.5 - spot.x, y + 0.5 - spot.y);
      image.at<float>(y, x) = static_cast<float>(1e4 * std::exp(-r * r / (2 * 10.0 * 10.0)));
    }
  }
  for (const Fit fit : {Fit::kLetterbox, Fit::kCorner, Fit::kStretch}) {
    const Letterbox letterbox(image.size(), {320, 320}, fit);
    cv::Mat input = letterbox.apply(image);
    input.setTo(0, input == 114);  // the padding
    const cv::Moments moments = cv::moments(input);
    const cv::Rect2d mapped = letterbox.toInput({spot.x - 1, spot.y - 1, 2, 2});
    // The spot is ten pixels wide: sampling it every second pixel moves its centroid by far less than this.
    EXPECT_NEAR(moments.m10 / moments.m00 + 0.5, mapped.x + 0.5 * mapped.width, 0.01);
    EXPECT_NEAR(moments.m01 / moments.m00 + 0.5, mapped.y + 0.5 * mapped.height, 0.01);
  }
}

}  // namespace
}  // namespace frugal_nav
