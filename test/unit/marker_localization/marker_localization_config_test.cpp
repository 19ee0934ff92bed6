#include <gtest/gtest.h>
#include <support/param_files.hpp>

#include <frugal_nav/ros/marker_localization_node_params.hpp>

namespace frugal_nav {
namespace {

TEST(MarkerLocalizationConfig, FileHoldsTheDefaults) {
  test::expectDefaults<MarkerLocalizationNodeParams>("marker_localization.yaml");
}

TEST(MarkerLocalizationConfig, ShippedMapIsSound) {
  const MarkerMap map = loadMarkerMap(std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/marker_hall_map.yaml");
  EXPECT_GT(map.markers.size(), 10U);
  EXPECT_EQ(map.frame, "map");
}

}  // namespace
}  // namespace frugal_nav
