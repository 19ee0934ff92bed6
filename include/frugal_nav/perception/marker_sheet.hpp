#pragma once

#include <string>

#include <opencv2/core.hpp>

#include <frugal_nav/perception/marker_dictionary.hpp>

namespace frugal_nav {

/// White that a marker needs around it, in shares of its side: with less than 0.12 OpenCV hardly finds it.
constexpr double kMarkerBorderShare = 0.17;

/// A paper's size.
struct PaperSize {
  double width_mm = 210.0;
  double height_mm = 297.0;
};

/// A page in SVG with one marker in true size, white around it, and its dictionary, id and side under it with
/// a ruler to check the print. Throws ConfigError when the id is not the dictionary's or the marker, with a
/// white border of 17 % of its side, does not fit the paper.
std::string markerSheet(const MarkerDictionary& dictionary, int id, double size_m, const PaperSize& paper);

/// A marker as a square 8-bit grey image for the simulator, `cell_px` pixels a cell, with a white border one
/// cell wide. Throws ConfigError when the id is not the dictionary's.
cv::Mat markerTexture(const MarkerDictionary& dictionary, int id, int cell_px);
/// The side of that image, border and all, for a marker of a size [m].
double markerTextureSide_m(const MarkerDictionary& dictionary, double size_m);

}  // namespace frugal_nav
