#include <limits>

#include <gtest/gtest.h>

#include <frugal_nav/common/laser_scan.hpp>

namespace frugal_nav {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

LaserScan soundScan() {
  LaserScan scan;
  scan.angle_min_rad = -M_PI;
  scan.angle_increment_rad = 2.0 * M_PI / 360;
  scan.range_min_m = 0.15;
  scan.range_max_m = 12.0;
  scan.ranges_m.assign(360, 2.0F);
  return scan;
}

void expectFault(const LaserScan& scan, const std::string& about) {
  const auto fault = findFault(scan);
  ASSERT_TRUE(fault.has_value()) << about;
  EXPECT_NE(fault->find(about), std::string::npos) << *fault;
}

TEST(LaserScan, ClassifiesByRep117) {
  const LaserScan scan = soundScan();
  EXPECT_EQ(classify(scan, 2.0F), Return::kHit);
  EXPECT_EQ(classify(scan, kInf), Return::kFree);
  EXPECT_EQ(classify(scan, -kInf), Return::kTooClose);
  EXPECT_EQ(classify(scan, 0.1F), Return::kTooClose);
  EXPECT_EQ(classify(scan, 0.0F), Return::kTooClose);
  EXPECT_EQ(classify(scan, 12.5F), Return::kUnknown);
  EXPECT_EQ(classify(scan, kNan), Return::kUnknown);
}

TEST(LaserScan, SoundScanHasNoFault) {
  EXPECT_FALSE(findFault(soundScan()).has_value());
  LaserScan nothing_near = soundScan();
  nothing_near.ranges_m.assign(360, kInf);
  EXPECT_FALSE(findFault(nothing_near).has_value());
}

TEST(LaserScan, AScanWithoutAReturnIsRefusedUnlessTheRulesAllowIt) {
  LaserScan scan = soundScan();
  scan.ranges_m.assign(360, kInf);
  const auto fault = findFault(scan, ScanRules{});
  ASSERT_TRUE(fault.has_value());
  EXPECT_NE(fault->find("no return at all"), std::string::npos) << *fault;
  ScanRules in_a_hall;
  in_a_hall.require_return = false;
  EXPECT_FALSE(findFault(scan, in_a_hall).has_value());
  scan.ranges_m[90] = 11.0F;
  EXPECT_FALSE(findFault(scan, ScanRules{}).has_value());
  scan.ranges_m[90] = -kInf;
  EXPECT_FALSE(findFault(scan, ScanRules{}).has_value()) << "too close is a return";
}

TEST(LaserScan, InfSaysNothingWhereTheRulesSaySo) {
  LaserScan scan = soundScan();
  scan.ranges_m[7] = kInf;
  EXPECT_EQ(readBy(ScanRules{}, scan).ranges_m[7], kInf);
  ScanRules failed_echoes;
  failed_echoes.inf_is_free = false;
  const LaserScan read = readBy(failed_echoes, scan);
  EXPECT_EQ(classify(read, read.ranges_m[7]), Return::kUnknown);
  EXPECT_EQ(read.ranges_m[8], scan.ranges_m[8]);
}

TEST(LaserScan, AcceptsOneRepeatedDirection) {
  LaserScan scan = soundScan();
  scan.ranges_m.assign(361, 1.0F);
  EXPECT_FALSE(findFault(scan).has_value());
  scan.ranges_m.assign(400, 1.0F);
  expectFault(scan, "360 degrees");
}

TEST(LaserScan, NamesItsFault) {
  LaserScan scan = soundScan();
  scan.ranges_m.clear();
  expectFault(scan, "empty");

  scan = soundScan();
  scan.ranges_m.assign(360, kNan);
  expectFault(scan, "NaN");
  scan.ranges_m[7] = 13.0F;  // beyond range_max says nothing either
  expectFault(scan, "NaN");

  scan.ranges_m.assign(360, 0.0F);
  expectFault(scan, "below range_min");
  scan.ranges_m.assign(360, -kInf);
  scan.ranges_m[7] = kNan;
  expectFault(scan, "below range_min");
  scan.ranges_m[8] = 0.2F;
  EXPECT_FALSE(findFault(scan).has_value()) << "one measured range shows that the laser works";

  scan = soundScan();
  scan.angle_increment_rad = 0.0;
  expectFault(scan, "angle_increment");
  scan.ranges_m.resize(2);
  for (const double increment_rad : {13.0, 1e-12}) {
    scan.angle_increment_rad = increment_rad;
    expectFault(scan, "angle_increment");
  }
  scan.angle_increment_rad = NAN;
  expectFault(scan, "angle_increment");

  scan = soundScan();
  scan.range_max_m = 0.1;
  expectFault(scan, "range_min");
  scan.range_max_m = NAN;
  expectFault(scan, "range_min");
  scan = soundScan();
  scan.range_min_m = -1.0;
  expectFault(scan, "range_min");
}

TEST(LaserScan, AcceptsAClockwiseScanner) {
  LaserScan scan = soundScan();
  scan.angle_min_rad = M_PI;
  scan.angle_increment_rad = -scan.angle_increment_rad;
  EXPECT_FALSE(findFault(scan).has_value());
}

TEST(ObstaclePoints, AreInTheBaseFrameAndKeepWhatIsTooClose) {
  LaserScan scan = soundScan();
  scan.angle_min_rad = 0.0;
  scan.angle_increment_rad = M_PI / 2;
  scan.ranges_m = {1.0F, kInf, -kInf, kNan};
  const auto points = obstaclePoints(scan, Pose2{0.1, 0.2, M_PI / 2});
  ASSERT_EQ(points.size(), 2U);
  EXPECT_LT((points[0] - Eigen::Vector2d(0.1, 1.2)).norm(), 1e-7);  // float ranges
  EXPECT_LT((points[1] - Eigen::Vector2d(0.1, 0.2 - 0.15)).norm(), 1e-7);
}

}  // namespace
}  // namespace frugal_nav
