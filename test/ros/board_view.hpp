#pragma once

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace frugal_nav::test {

/// How far ahead the board of boardAhead() stands [m].
constexpr double kBoard_m = 1.6;

/// What the camera of CameraGraph sees (320x240, f = 266 px, level, 0.4 m up) of a red board ahead, on a
/// floor that reaches to a wall at 4 m: something at distance d meets the floor in row 119.5 + 106.4 / d.
inline cv::Mat boardAhead() {
  cv::Mat image(240, 320, CV_8UC3, cv::Scalar(185, 190, 190));
  cv::rectangle(image, {0, 146, 320, 94}, cv::Scalar(90, 120, 110), cv::FILLED);
  cv::rectangle(image, {130, 60, 60, 126}, cv::Scalar(40, 50, 190), cv::FILLED);
  cv::Mat noise(image.size(), CV_16SC3);
  cv::RNG(500001).fill(noise, cv::RNG::NORMAL, 0.0, 3.0);
  cv::add(image, noise, image, cv::noArray(), CV_8U);
  return image;
}

}  // namespace frugal_nav::test
