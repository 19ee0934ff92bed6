#include "support/shared_data.hpp"
#include "support/temp_folder.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/random.hpp>
#include <frugal_nav/eval/suite.hpp>

namespace frugal_nav::eval {
namespace {

Rows runOn(const std::string& folder) {
  const auto suite = makeSuite("markers");
  suite->configure({{"mrclam", folder}});
  suite->prepare({});
  return suite->runTrial({0, 500000});
}

std::string faultOn(const std::string& folder) {
  try {
    runOn(folder);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

std::string lineOf(const char* format, double a, double b, double c, double d) {
  char text[160];
  std::snprintf(text, sizeof text, format, a, b, c, d);
  return text;
}

/// One minute of a robot's circle in the data set's format, with sightings of two landmarks and of a robot.
void writeCircle(const test::TempFolder& folder) {
  const Eigen::Vector2d landmarks[] = {{3.0, 0.0}, {-2.0, 3.0}};
  Random random(500000);
  std::string odometry = "# Time [s]    forward velocity [m/s]    angular velocity[rad/s]\n";
  std::string truth;
  std::string measurements;
  for (int i = 0; i <= 1200; ++i) {
    const double t = 0.05 * i;
    const Pose2 pose = arcMotion({0.1, 0.1}, t);
    odometry += lineOf("%.3f 0.1 %.3f\n", 1e9 + t, 0.1, 0, 0);
    truth += lineOf("%.3f \t %.8f \t %.8f \t %.8f \n", 1e9 + t, pose.x_m, pose.y_m, pose.yaw_rad);
    if (i % 20 != 10) continue;
    for (const int k : {0, 1}) {
      measurements += lineOf("%.3f %.0f %.3f %.3f\n", 1e9 + t, 72 + k,
                             (landmarks[k] - pose.position()).norm() + random.normal(0.05),
                             bearingTo(pose, landmarks[k]) + random.normal(0.02));
    }
    measurements += lineOf("%.3f %.0f %.3f %.3f\n", 1e9 + t, 14, 1.0, 0.0);
  }
  folder.write("Barcodes.dat", "# Subject #    Barcode #\n 2 14\n 6 72\n 7 73\n");
  folder.write("Landmark_Groundtruth.dat", " 6 3.0 0.0 0.0001 0.0001\n 7 -2.0 3.0 0.0001 0.0001\n");
  folder.write("Robot3_Odometry.dat", odometry);
  folder.write("Robot3_Groundtruth.dat", truth);
  folder.write("Robot3_Measurement.dat", measurements);
}

TEST(MarkersSuite, ScoresEveryRobotOfAFolder) {
  const test::TempFolder folder;
  writeCircle(folder);
  const Rows rows = runOn(folder.path());
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].at("robot"), "Robot3");
  // Sightings of 0.05 m and 0.02 rad; what the filter believes of them is wider, so it is better than it
  // says.
  EXPECT_LT(rows[0].at("position_rmse_m"), 0.1);
  EXPECT_LT(rows[0].at("yaw_rmse_deg"), 2.0);
  EXPECT_GT(rows[0].at("anees"), 0.0);
  EXPECT_LT(rows[0].at("anees"), 1.0);
  EXPECT_EQ(rows[0].at("gated_share"), 0.0);
  const auto suite = makeSuite("markers");
  suite->configure({{"mrclam", folder.path()}});
  EXPECT_EQ(suite->summarise(rows).at("anees"), rows[0].at("anees"));
  EXPECT_THAT(suite->runTrial({1, 500001}), testing::IsEmpty());
}

TEST(MarkersSuite, NamesWhatIsWrongWithAFolder) {
  EXPECT_THAT(faultOn("/no/such/folder"), testing::HasSubstr("/no/such/folder"));
  const test::TempFolder folder;
  writeCircle(folder);
  folder.write("Robot3_Measurement.dat", "# Time\n1000000000.5 72 3.0 0.1\n1000000000.6 72 far 0.1\n");
  EXPECT_THAT(faultOn(folder.path()), testing::HasSubstr("Robot3_Measurement.dat:3: not 4 numbers"));
  folder.write("Robot3_Measurement.dat", "");
  folder.write("Robot3_Groundtruth.dat", "");
  EXPECT_THAT(faultOn(folder.path()), testing::HasSubstr("no truth"));
}

TEST(MarkersSuite, KnowsWhereTheRealRobotsAre) {
  const std::string archive = test::sharedFile("mrclam6/robots_1_2.tar.xz");
  if (archive.empty()) GTEST_SKIP() << "no mrclam6/robots_1_2.tar.xz beside the source tree";
  const test::TempFolder folder;
  ASSERT_EQ(std::system(("tar xJf '" + archive + "' -C '" + folder.path() + "'").c_str()), 0);
  const Rows rows = runOn(folder.path());
  ASSERT_EQ(rows.size(), 2U);
  // A filter of the pose alone, with these data, reaches 0.20 m and 0.27 m; dead reckoning 4.4 m and 3.0 m.
  EXPECT_LT(rows[0].at("position_rmse_m"), 0.14);
  EXPECT_LT(rows[1].at("position_rmse_m"), 0.18);
  for (const Json& row : rows) {
    EXPECT_GT(row.at("anees"), 0.5) << row;
    EXPECT_LT(row.at("anees"), 2.0) << row;
    EXPECT_LT(row.at("gated_share"), 0.05) << row;
  }
}

}  // namespace
}  // namespace frugal_nav::eval
