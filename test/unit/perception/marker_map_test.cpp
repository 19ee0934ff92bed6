#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <support/temp_folder.hpp>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/perception/marker_map.hpp>
#include <frugal_nav/perception/marker_map_check.hpp>

namespace frugal_nav {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kHall = R"(
frame: hall
dictionary: DICT_5X5_100
size_m: 0.20
markers:
  - {id: 4, position: [4.0, 1.0, 0.5], rpy: [1.5707963, 0.0, -1.5707963]}
  - {id: 60, size_m: 0.15, position: [0.0, 2.0, 0.6], rpy: [1.5707963, 0.0, 0.0]}
)";

/// What is said about a map; empty when it is taken.
std::string faultOf(const std::string& yaml) {
  try {
    parseMarkerMap(yaml, "hall.yaml");
    return "";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

std::string mapWith(const std::string& markers) { return "size_m: 0.2\nmarkers:\n" + markers; }

constexpr const char* kOnWall = "  - {id: 1, position: [4.0, 0.0, 0.5], rpy: [1.5708, 0.0, -1.5708]}\n";

TEST(MarkerMap, HoldsPlacesSizesAndWhitelist) {
  const MarkerMap map = parseMarkerMap(kHall, "hall.yaml");
  EXPECT_EQ(map.frame, "hall");
  EXPECT_EQ(map.dictionary, "DICT_5X5_100");
  EXPECT_EQ(map.whitelist, (std::vector<int>{4, 60}));
  ASSERT_EQ(map.markers.size(), 2U);
  EXPECT_DOUBLE_EQ(map.markers.at(4).size_m, 0.20);
  EXPECT_DOUBLE_EQ(map.markers.at(60).size_m, 0.15);
  // The header's words for these two: faces -x; faces -y. Both upright.
  const Eigen::Matrix3d wall_x = map.markers.at(4).map_from_marker.linear();
  const Eigen::Matrix3d wall_y = map.markers.at(60).map_from_marker.linear();
  EXPECT_LT((wall_x.col(2) - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-6);
  EXPECT_LT((wall_x.col(1) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-6);
  EXPECT_LT((wall_y.col(2) - Eigen::Vector3d(0, -1, 0)).norm(), 1e-6);
  EXPECT_LT((wall_y.col(1) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-6);
  EXPECT_LT((map.markers.at(4).map_from_marker.translation() - Eigen::Vector3d(4.0, 1.0, 0.5)).norm(), 1e-9);
}

TEST(MarkerMap, ReadsAFileAndNamesOneThatIsNotThere) {
  const test::TempFolder folder;
  EXPECT_EQ(loadMarkerMap(folder.write("hall.yaml", kHall)).markers.size(), 2U);
  EXPECT_THROW(loadMarkerMap(folder.path("hell.yaml")), ConfigError);
}

TEST(MarkerMap, NamesTheKeyOfEachFault) {
  EXPECT_EQ(faultOf(mapWith(kOnWall)), "");
  EXPECT_THAT(faultOf(mapWith(std::string(kOnWall) + kOnWall)),
              HasSubstr("markers[1] (id 1)/id is there twice"));
  EXPECT_THAT(faultOf(std::string("markers:\n") + kOnWall), HasSubstr("markers[0] (id 1)/size_m is missing"));
  EXPECT_THAT(faultOf("size_m: 200\nmarkers:\n" + std::string(kOnWall)), HasSubstr("size_m = 200"));
  EXPECT_THAT(faultOf("size_m: 200\nmarkers:\n" + std::string(kOnWall)), HasSubstr("mm or cm"));
  EXPECT_THAT(
      faultOf(mapWith("  - {id: 1, position: [4.0, 0.0, 0.5], rpy: [90, 0, -90]}\n")),
      HasSubstr("markers[0] (id 1)/rpy holds 90: more than a full turn in radians; is it in degrees?"));
  EXPECT_THAT(faultOf(mapWith("  - {id: 1, position: [4000, 0, 500], rpy: [1.57, 0, 0]}\n")),
              HasSubstr("markers[0] (id 1)/position holds 4000"));
  EXPECT_THAT(faultOf(mapWith("  - {id: 1, position: [4, 0], rpy: [1.57, 0, 0]}\n")),
              HasSubstr("/position must be"));
  EXPECT_THAT(faultOf(mapWith("  - {id: 1, position: [4, 0, .nan], rpy: [1.57, 0, 0]}\n")),
              HasSubstr("/position must be"));
  EXPECT_THAT(faultOf(mapWith("  - {id: 1, position: [4, 0, 1]}\n")),
              HasSubstr("markers[0] (id 1)/rpy must be"));
  EXPECT_THAT(faultOf(mapWith("  - {id: 77, position: [4, 0, 1], rpy: [0, 0, 0]}\n")),
              HasSubstr("markers[0]/id = 77 is not in DICT_4X4_50, which has 0 to 49"));
  EXPECT_THAT(faultOf(mapWith("  - {position: [4, 0, 1], rpy: [0, 0, 0]}\n")),
              HasSubstr("markers[0]/id must be"));
  EXPECT_THAT(faultOf(mapWith("  - {id: 1, pose: [4, 0, 1], rpy: [0, 0, 0]}\n")),
              HasSubstr("markers[0]/pose is unknown"));
  EXPECT_THAT(faultOf("dictionary: 4x4\n" + mapWith(kOnWall)),
              AllOf(HasSubstr("DICT_4X4_50"), Not(HasSubstr("which has"))));
  EXPECT_THAT(faultOf("size_m: 0.2\n"), HasSubstr("markers must be a list"));
  EXPECT_THAT(faultOf("whitelist: 1\n" + mapWith(kOnWall)), HasSubstr("whitelist must be a list"));
  EXPECT_THAT(faultOf("just words"), HasSubstr("expected the keys"));
  EXPECT_THAT(faultOf("markers: [\n"), HasSubstr("hall.yaml:"));
}

TEST(MarkerMap, ListsAllFaultsAtOnce) {
  const std::string faults = faultOf(mapWith(
      "  - {id: 1, position: [4, 0], rpy: [90, 0, 0]}\n  - {id: 99, position: [1, 1, 1], rpy: [0, 0, 0]}\n"));
  EXPECT_THAT(faults, HasSubstr("markers[0] (id 1)/position"));
  EXPECT_THAT(faults, HasSubstr("markers[0] (id 1)/rpy"));
  EXPECT_THAT(faults, HasSubstr("markers[1]/id"));
}

TEST(MarkerMap, KeepsToItsWhitelist) {
  const MarkerMap map = parseMarkerMap("whitelist: [1, 9]\n" + mapWith(kOnWall), "hall.yaml");
  EXPECT_EQ(map.whitelist, (std::vector<int>{1, 9}));
}

std::vector<std::string> suspicionsOf(const std::string& markers) {
  return suspicionsAbout(parseMarkerMap(mapWith(markers), "hall.yaml"));
}

TEST(MarkerMapCheck, IsContentWithMarkersOnWalls) {
  EXPECT_TRUE(suspicionsAbout(parseMarkerMap(kHall, "hall.yaml")).empty());
}

TEST(MarkerMapCheck, FindsMarkersThatOverlapEvenByTheirBorders) {
  const auto beside = [](const std::string& y) {
    return std::string(kOnWall) + "  - {id: 2, position: [4.0, " + y +
           ", 0.5], rpy: [1.5708, 0.0, -1.5708]}\n";
  };
  // Side 0.20 m with 17 % around it: 0.268 m from centre to centre.
  EXPECT_EQ(suspicionsOf(beside("0.26")).size(), 1U);
  EXPECT_TRUE(suspicionsOf(beside("0.275")).empty());
  // Turned by 45 degrees in its plane the neighbour reaches sqrt(2) as far: 0.134 + 0.190 m.
  const auto turned = [](const std::string& y) {
    return std::string(kOnWall) + "  - {id: 2, position: [4.0, " + y +
           ", 0.5], rpy: [1.5708, 0.7854, -1.5708]}\n";
  };
  EXPECT_EQ(suspicionsOf(turned("0.31")).size(), 1U);
  EXPECT_TRUE(suspicionsOf(turned("0.33")).empty());
  // Behind one another, and back to back, they do not disturb.
  EXPECT_TRUE(suspicionsOf(std::string(kOnWall) +
                           "  - {id: 2, position: [4.2, 0.0, 0.5], rpy: [1.5708, 0.0, -1.5708]}\n")
                  .empty());
  EXPECT_TRUE(suspicionsOf(std::string(kOnWall) +
                           "  - {id: 2, position: [4.02, 0.0, 0.5], rpy: [1.5708, 0.0, 1.5708]}\n")
                  .empty());
}

TEST(MarkerMapCheck, FindsWhatIsOutOfReachOrInAnotherUnit) {
  const auto one = [](const std::string& position, const std::string& rpy) {
    return "  - {id: 1, position: [" + position + "], rpy: [" + rpy + "]}\n";
  };
  EXPECT_THAT(suspicionsOf(one("4, 0, 0.05", "1.5708, 0, 0")),
              ::testing::ElementsAre(HasSubstr("lower edge")));
  EXPECT_THAT(suspicionsOf(one("4, 0, 50", "1.5708, 0, 0")), ::testing::ElementsAre(HasSubstr("its centre")));
  EXPECT_THAT(suspicionsOf(one("4, 0, 1", "0, 0, 0")), ::testing::ElementsAre(HasSubstr("looks 90 deg up")));
  EXPECT_THAT(suspicionsOf(one("4, 0, 1", "3.1416, 0, 0")), ::testing::ElementsAre(HasSubstr("down")));
  EXPECT_THAT(suspicionsOf(one("400, 0, 1", "1.5708, 0, 0") +
                           "  - {id: 2, position: [0, 0, 1], rpy: [1.5708, 0, 0]}\n"),
              ::testing::ElementsAre(HasSubstr("400 m apart")));
}

TEST(MarkerMapCheck, FindsAWhitelistedIdWithoutAPlace) {
  EXPECT_THAT(suspicionsAbout(parseMarkerMap("whitelist: [1, 9]\n" + mapWith(kOnWall), "hall.yaml")),
              ::testing::ElementsAre(HasSubstr("marker 9 has no place")));
}

}  // namespace
}  // namespace frugal_nav
