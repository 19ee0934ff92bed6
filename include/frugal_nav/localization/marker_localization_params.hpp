#pragma once

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/localization/pose_filter_params.hpp>
#include <frugal_nav/perception/marker_detector.hpp>
#include <frugal_nav/perception/marker_localizer.hpp>

namespace frugal_nav {

/// Localization by markers, wheels and gyro.
struct MarkerLocalizationParams {
  MarkerDetectorParams detector = anyDictionary();
  MarkerLocalizerParams localizer;
  PoseFilterParams filter;
  double without_markers_s = 1.0;
  double max_sigma_m = 0.5;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("detector", detector);
    visit("localizer", localizer);
    visit("filter", filter);
    visit("without_markers_s", without_markers_s,
          Field{"s", "after so long without a fix the markers count as out of view", 0.05, 600.0});
    visit("max_sigma_m", max_sigma_m,
          Field{"m", "standard deviation of the position, its worst way, past which the robot is lost", 0.01,
                100.0});
  }

 private:
  static MarkerDetectorParams anyDictionary() {
    MarkerDetectorParams params;
    params.dictionary.clear();  // the map names it
    return params;
  }
};

}  // namespace frugal_nav
