#include <cmath>
#include <regex>
#include <string>

#include <gtest/gtest.h>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/marker_detector.hpp>
#include <frugal_nav/perception/marker_sheet.hpp>

namespace frugal_nav {
namespace {

constexpr int kPixelsPerMm = 4;

/// Prints a sheet: its rectangles in black on white. `box` is what they cover, without the ruler.
cv::Mat printed(const std::string& svg, const PaperSize& paper, cv::Rect& box) {
  cv::Mat page(static_cast<int>(paper.height_mm * kPixelsPerMm),
               static_cast<int>(paper.width_mm * kPixelsPerMm), CV_8UC1, cv::Scalar(255));
  const std::regex rectangle(
      R"re(<rect x="([0-9.]+)" y="([0-9.]+)" width="([0-9.]+)" height="([0-9.]+)"/>)re");
  for (std::sregex_iterator it(svg.begin(), svg.end(), rectangle), end; it != end; ++it) {
    const auto px = [&it](int group) {
      return static_cast<int>(std::lround(std::stod((*it)[group].str()) * kPixelsPerMm));
    };
    const cv::Rect black(px(1), px(2), px(3), px(4));
    page(black & cv::Rect(0, 0, page.cols, page.rows)).setTo(0);
    const bool is_ruler = std::stod((*it)[3].str()) < 1.0 || std::stod((*it)[4].str()) < 1.0;
    if (!is_ruler) box |= black;
  }
  return page;
}

TEST(MarkerSheet, HoldsTheMarkerInTrueSize) {
  const PaperSize paper;
  for (const char* name : {"DICT_4X4_50", "DICT_6X6_250", "DICT_APRILTAG_36h11"}) {
    cv::Rect box;
    const cv::Mat page = printed(markerSheet(MarkerDictionary(name), 23, 0.15, paper), paper, box);
    EXPECT_NEAR(box.width, 150 * kPixelsPerMm, 1) << name;
    EXPECT_NEAR(box.height, 150 * kPixelsPerMm, 1) << name;
    MarkerDetectorParams params;
    params.dictionary = name;
    const MarkerFindings found = MarkerDetector(params).detect(page);
    ASSERT_EQ(found.markers.size(), 1U) << name;
    EXPECT_EQ(found.markers[0].id, 23);
    // Upright: the first corner is the page's upper left one.
    EXPECT_NEAR(found.markers[0].pixels[0].x(), box.x - 0.5, 1.0);
    EXPECT_NEAR(found.markers[0].pixels[0].y(), box.y - 0.5, 1.0);
  }
}

TEST(MarkerSheet, LeavesAWhiteBorderOf17Percent) {
  const PaperSize paper;
  cv::Rect box;
  const cv::Mat page = printed(markerSheet(MarkerDictionary("DICT_4X4_50"), 0, 0.15, paper), paper, box);
  const int border = static_cast<int>(0.17 * box.width);
  const cv::Rect around(box.x - border, box.y - border, box.width + 2 * border, box.height + 2 * border);
  ASSERT_EQ(around & cv::Rect(0, 0, page.cols, page.rows), around);
  cv::Mat outside = page.clone();
  outside(box).setTo(255);
  double darkest = 0.0;
  cv::minMaxLoc(outside(around), &darkest);
  EXPECT_EQ(darkest, 255.0);
}

TEST(MarkerSheet, SaysWhatItShows) {
  const std::string svg = markerSheet(MarkerDictionary("DICT_4X4_50"), 7, 0.125, PaperSize());
  EXPECT_NE(svg.find("DICT_4X4_50   id 7   side 125 mm"), std::string::npos);
}

TEST(MarkerSheet, RefusesWhatDoesNotFitOrDoesNotExist) {
  const MarkerDictionary dictionary("DICT_4X4_50");
  EXPECT_NO_THROW(markerSheet(dictionary, 0, 0.156, PaperSize()));
  EXPECT_THROW(markerSheet(dictionary, 0, 0.158, PaperSize()), ConfigError);  // 0.158 * 1.34 = 0.212 m
  EXPECT_THROW(markerSheet(dictionary, 50, 0.1, PaperSize()), ConfigError);
  EXPECT_THROW(markerSheet(dictionary, 0, 0.0, PaperSize()), ConfigError);
}

TEST(MarkerTexture, IsTheMarkerInAWhiteBorderOneCellWide) {
  const MarkerDictionary dictionary("DICT_4X4_50");
  const cv::Mat texture = markerTexture(dictionary, 23, 16);
  ASSERT_EQ(texture.size(), cv::Size(128, 128));
  cv::Mat whole(8, 8, CV_8UC1, cv::Scalar(255));
  dictionary.cellsOf(23).copyTo(whole(cv::Rect(1, 1, 6, 6)));
  for (int row = 0; row < texture.rows; ++row) {
    for (int column = 0; column < texture.cols; ++column)
      ASSERT_EQ(texture.at<unsigned char>(row, column), whole.at<unsigned char>(row / 16, column / 16));
  }
  EXPECT_NEAR(markerTextureSide_m(dictionary, 0.3), 0.4, 1e-12);
  EXPECT_THROW(markerTexture(dictionary, 50, 16), ConfigError);
}

}  // namespace
}  // namespace frugal_nav
