#pragma once

#include <opencv2/imgproc.hpp>

namespace frugal_nav::test {

/// A face as a child would shade it: 120 wide and 160 high about (320, 200).
inline cv::Mat drawnFace() {
  cv::Mat image(480, 640, CV_8UC3, cv::Scalar(150, 160, 165));
  const auto ellipse = [&image](int x, int y, int a, int b, const cv::Scalar& color) {
    cv::ellipse(image, {320 + x, 200 + y}, {a, b}, 0, 0, 360, color, cv::FILLED, cv::LINE_AA);
  };
  ellipse(0, 300, 170, 190, {90, 60, 50});  // shoulders
  ellipse(0, 80, 34, 60, {120, 150, 195});  // neck
  ellipse(0, -22, 66, 78, {25, 35, 45});    // hair
  ellipse(0, 0, 58, 76, {135, 170, 220});   // face
  ellipse(0, -60, 52, 22, {25, 35, 45});    // fringe
  for (const int side : {-1, 1}) {
    ellipse(24 * side, -12, 17, 9, {105, 135, 185});  // sockets
    ellipse(24 * side, -24, 14, 3, {30, 40, 60});     // brows
    ellipse(24 * side, -10, 11, 6, {235, 238, 240});
    ellipse(24 * side, -10, 5, 6, {30, 30, 35});
    ellipse(7 * side, 24, 4, 3, {80, 105, 150});  // nostrils
    ellipse(34 * side, 22, 14, 12, {130, 160, 222});
  }
  ellipse(0, 10, 7, 18, {145, 182, 230});  // nose
  ellipse(0, 46, 22, 6, {85, 85, 170});    // mouth
  ellipse(0, 45, 18, 1, {50, 50, 110});
  cv::GaussianBlur(image, image, {5, 5}, 1.2);
  return image;
}

}  // namespace frugal_nav::test
