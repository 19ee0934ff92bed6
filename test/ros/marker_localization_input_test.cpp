// What marker_localization does with input that is wrong, late, early or from another time.

#include "marker_localization_graph.hpp"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <support/temp_folder.hpp>

namespace frugal_nav {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class MarkerLocalizationInputTest : public test::MarkerLocalizationGraph {};

TEST_F(MarkerLocalizationInputTest, TakesALateImageButNoneFromTheFuture) {
  start();
  localize();
  drive(10);
  sensor_msgs::Image image = picture();
  image.header.stamp -= ros::Duration(0.3);
  const MarkerObservationArray* late = show(image);
  ASSERT_NE(late, nullptr);
  EXPECT_TRUE(late->accepted) << late->reason;
  image.header.stamp = graph_.clock.now() + ros::Duration(5.0);
  const MarkerObservationArray* early = show(image);
  ASSERT_NE(early, nullptr);
  EXPECT_FALSE(early->accepted);
  EXPECT_EQ(early->reason, toText(FilterStatus::kFromFuture));
}

// A stamp from the future or none, or one that was overtaken: what comes after it is no jump back in time.
TEST_F(MarkerLocalizationInputTest, ABadStampForgetsNothing) {
  start();
  localize();
  for (const double ahead_s : {5.0, -0.08}) {
    tick();
    sensor_msgs::Image image = picture();
    image.header.stamp += ros::Duration(ahead_s);
    ASSERT_NE(show(image), nullptr);
    graph_.publishOdometry(graph_.clock.now() + ros::Duration(ahead_s));
    expectGoesOn();
  }
  sensor_msgs::Image unstamped = picture();
  unstamped.header.stamp = ros::Time();
  graph_.publish(unstamped);
  graph_.publishOdometry(ros::Time());
  ASSERT_TRUE(waitForValue("odom", "no stamp"));
  expectGoesOn();
  EXPECT_EQ(observations_.messages[observations_.messages.size() - 2].reason, "the image has no stamp");
  EXPECT_TRUE(waitForValue("jumps in time", "0"));
}

// Stamps go back far while ROS time does not: a bag that is played again without its clock.
TEST_F(MarkerLocalizationInputTest, StampsThatGoBackFarStartAnew) {
  start();
  localize();
  for (int i = 0; i < 5; ++i) {
    graph_.clock.advance(0.05);
    graph_.publishOdometry(graph_.clock.now() - ros::Duration(20.0));
  }
  EXPECT_TRUE(waitForValue("jumps in time", "1"));
  EXPECT_EQ(poseAt(graph_.clock.now() - ros::Duration(20.0)), nullptr);
}

TEST_F(MarkerLocalizationInputTest, AnImuWithoutAGyroIsLeftOut) {
  start();
  localize();
  no_gyro_ = true;
  ASSERT_TRUE(test::waitUntil([this] {
    tick();
    return status().find("gyro silent") != std::string::npos;
  }));
  EXPECT_TRUE(waitForValue("imu/data_raw", "angular_velocity_covariance"));
}

TEST_F(MarkerLocalizationInputTest, NumbersThatAreNoneAreNamedAndSurvived) {
  start();
  localize();
  tick(kNan);
  ASSERT_TRUE(test::waitUntil([this] { return poseAt(graph_.clock.now()) != nullptr; }));
  expectAtTruth(poseAt(graph_.clock.now())->pose.pose);
  EXPECT_TRUE(waitForValue("imu/data_raw", toText(FilterStatus::kNotFinite)));
}

TEST_F(MarkerLocalizationInputTest, AMarkerOfTheWrongSizeMovesNothing) {
  start();
  localize();
  MarkerMap map = test::wallMap();
  for (auto& [id, marker] : map.markers) marker.size_m *= 0.7;
  for (int i = 0; i < 5; ++i) {
    tick();
    const MarkerObservationArray* seen = show(picture(map));
    ASSERT_NE(seen, nullptr);
    EXPECT_FALSE(seen->accepted);
    EXPECT_THAT(seen->reason, testing::Not(testing::IsEmpty()));
  }
  drive(1);
  expectAtTruth(poses_.messages.back().pose.pose);
}

TEST_F(MarkerLocalizationInputTest, AnImageWithoutCalibrationIsNamed) {
  start();
  sensor_msgs::CameraInfo zeros = graph_.info();
  zeros.K.fill(0.0);
  graph_.publish(zeros);
  tick();
  const MarkerObservationArray* seen = nullptr;
  ASSERT_TRUE(test::waitUntil([&] {  // the image may overtake the camera_info
    tick();
    seen = show(picture());
    return seen == nullptr || !seen->accepted;
  }));
  ASSERT_NE(seen, nullptr);
  EXPECT_THAT(seen->reason, HasSubstr("calibrate"));
}

TEST_F(MarkerLocalizationInputTest, TimeJumpingBackStartsAnew) {
  start();
  localize();
  const std::size_t poses = poses_.messages.size();
  graph_.clock.set(graph_.clock.now() - ros::Duration(20.0));
  drive(5);
  EXPECT_EQ(poses_.messages.size(), poses);
  localize();
  expectAtTruth(poses_.messages.back().pose.pose);
}

/// What the node says when it is started with a map of this text.
test::ProgramResult startWith(const std::string& map, const std::string& arguments = "") {
  const test::TempFolder folder;
  const std::string file = folder.write("map.yaml", map);
  return test::runProgram("marker_localization_node",
                          "__name:=marker_alone _marker_map:=" + file + " " + arguments);
}

TEST(MarkerLocalizationNode, ABadMapEndsItWithWhatIsWrong) {
  const std::string marker = "  - {id: 3, position: [4.0, 0.6, 0.5], rpy: [1.5707963, 0.0, -1.5707963]}\n";
  const test::ProgramResult twice = startWith("size_m: 0.2\nmarkers:\n" + marker + marker);
  EXPECT_EQ(twice.exit_code, 1);
  EXPECT_THAT(twice.output, AllOf(HasSubstr("FATAL"), HasSubstr("3"), HasSubstr("map.yaml")));
  const test::ProgramResult unknown = startWith("dictionary: DICT_9X9_50\nsize_m: 0.2\nmarkers:\n" + marker);
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, AllOf(HasSubstr("FATAL"), HasSubstr("DICT_9X9_50"), HasSubstr("DICT_4X4_50")));
  const test::ProgramResult other =
      startWith("size_m: 0.2\nmarkers:\n" + marker, "_detector/dictionary:=DICT_6X6_50");
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.output, AllOf(HasSubstr("DICT_6X6_50"), HasSubstr("DICT_4X4_50")));
}

TEST(MarkerLocalizationNode, NoMapAndUnknownParametersEndIt) {
  const test::ProgramResult none = test::runProgram("marker_localization_node", "__name:=marker_bare");
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.output, AllOf(HasSubstr("FATAL"), HasSubstr("marker_map")));
  const test::ProgramResult missing =
      test::runProgram("marker_localization_node", "__name:=marker_alone _marker_map:=/nowhere/hall.yaml");
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.output, HasSubstr("/nowhere/hall.yaml"));
  const test::ProgramResult unknown = test::runProgram(
      "marker_localization_node", "__name:=marker_alone _marker_map:=" + test::kWallMap + " _use_gps:=true");
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, HasSubstr("use_gps"));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "marker_localization_input_test");
  ros::NodeHandle nh;  // keeps ROS running between the tests
  return RUN_ALL_TESTS();
}
