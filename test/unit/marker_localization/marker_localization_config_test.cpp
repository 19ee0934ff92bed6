#include <gtest/gtest.h>
#include <support/param_files.hpp>

#include <frugal_nav/ros/marker_localization_node_params.hpp>

namespace frugal_nav {
namespace {

TEST(MarkerLocalizationConfig, FileHoldsTheDefaults) {
  test::expectDefaults<MarkerLocalizationNodeParams>("marker_localization.yaml");
}

TEST(MarkerLocalizationConfig, WhatOnlyAStartingFilterTakesIsNotLive) {
  int found = 0;
  for (const FieldDescription& row : describe(PoseFilterParams{})) {
    if (row.name.find("_sigma") == std::string::npos && row.name.rfind("estimate_", 0) != 0) continue;
    EXPECT_FALSE(row.field.live) << row.name;
    ++found;
  }
  EXPECT_EQ(found, 5);
}

TEST(MarkerLocalizationConfig, ShippedMapIsSound) {
  const MarkerMap map = loadMarkerMap(std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/marker_hall_map.yaml");
  EXPECT_GT(map.markers.size(), 10U);
  EXPECT_EQ(map.frame, "map");
}

}  // namespace
}  // namespace frugal_nav
