#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <frugal_nav/mission/waypoint_list.hpp>

namespace frugal_nav {
namespace {

using testing::HasSubstr;

/// The message of the ConfigError a text leads to.
std::string fault(const std::string& yaml) {
  try {
    parseWaypoints(yaml, "tour.yaml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(WaypointList, ReadsPositionsAndHeadings) {
  const WaypointList list = parseWaypoints(
      "frame: odom\nloop: true\nstart_delay_s: 1.5\nwaypoints:\n  - [1.0, 2]\n  - [3, -4.5, 1.57]\n",
      "tour.yaml");
  EXPECT_EQ(list.frame, "odom");
  EXPECT_TRUE(list.loop);
  EXPECT_DOUBLE_EQ(list.start_delay_s, 1.5);
  ASSERT_EQ(list.waypoints.size(), 2U);
  EXPECT_DOUBLE_EQ(list.waypoints[0].position.y(), 2.0);
  EXPECT_FALSE(list.waypoints[0].yaw_rad);
  EXPECT_DOUBLE_EQ(list.waypoints[1].yaw_rad.value(), 1.57);
}

TEST(WaypointList, NamesFileLineAndEntryOfABadOne) {
  const std::string start = "frame: odom\nwaypoints:\n  - [1, 2]\n";
  EXPECT_THAT(fault(start + "  - [1]\n"), HasSubstr("tour.yaml:4: waypoint 2 must be"));
  EXPECT_THAT(fault(start + "  - [1, left]\n"), HasSubstr("tour.yaml:4: waypoint 2 holds something"));
  EXPECT_THAT(fault(start + "  - [1, .nan]\n"), HasSubstr("waypoint 2 is not finite"));
  EXPECT_THAT(fault(start + "  - 7\n"), HasSubstr("waypoint 2 must be"));
}

TEST(WaypointList, RefusesWhatItDoesNotKnow) {
  EXPECT_THAT(fault("frame: odom\nspeed: 3\nwaypoints: [[1, 2]]\n"),
              HasSubstr("tour.yaml:2: unknown key \"speed\""));
  EXPECT_THAT(fault("waypoints: [[1, 2]]\n"), HasSubstr("\"frame\" is missing"));
  EXPECT_THAT(fault("frame: odom\nwaypoints: []\n"), HasSubstr("missing or empty"));
  EXPECT_THAT(fault("frame: odom\nloop: 3\nwaypoints: [[1, 2]]\n"), HasSubstr("tour.yaml:2: \"loop\""));
  EXPECT_THAT(fault("frame: odom\nstart_delay_s: -1\nwaypoints: [[1, 2]]\n"),
              HasSubstr("must not be negative"));
  EXPECT_THAT(fault("frame: [odom\n"), HasSubstr("tour.yaml:"));
  EXPECT_THAT(fault("- 1\n"), HasSubstr("expected"));
}

TEST(WaypointList, NamesAFileThatIsNotThere) {
  try {
    readWaypoints("no_such_tour.yaml");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no_such_tour.yaml: cannot be read"));
  }
}

}  // namespace
}  // namespace frugal_nav
