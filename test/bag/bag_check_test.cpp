#include "support/ros_test.hpp"

#include <cstdio>
#include <fstream>
#include <functional>
#include <string>

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/LaserScan.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include <frugal_nav/ros/bag_check.hpp>

namespace frugal_nav {
namespace {

/// A bag of its own for each test: a scan every 0.1 s from 100 s on.
class BagCheck : public testing::Test {
 protected:
  ~BagCheck() override { std::remove(path_.c_str()); }

  static sensor_msgs::LaserScan scanAt(double time_s) {
    sensor_msgs::LaserScan scan;
    scan.header.stamp = ros::Time(time_s);
    scan.header.frame_id = "laser";
    scan.ranges.assign(360, 1.0F);
    return scan;
  }
  /// Writes twenty scans, each as `change` leaves it.
  void write(const std::function<void(int, sensor_msgs::LaserScan&)>& change) {
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    for (int i = 0; i < 20; ++i) {
      sensor_msgs::LaserScan scan = scanAt(100.0 + 0.1 * i);
      change(i, scan);
      bag.write("scan", ros::Time(100.0 + 0.1 * i), scan);
    }
  }
  BagReport check(const std::vector<TopicExpectation>& expectations = {}) {
    return checkBag(path_, expectations);
  }
  /// The one problem there must be, as text.
  std::string onlyProblem(const std::vector<TopicExpectation>& expectations = {}) {
    const BagReport report = check(expectations);
    EXPECT_EQ(report.problems.size(), 1U) << toText(report);
    return toText({{}, report.problems});
  }
  static TopicExpectation expectScan() {
    TopicExpectation scan;
    scan.topic = "scan";
    scan.type = "sensor_msgs/LaserScan";
    scan.min_rate_hz = 5.0;
    scan.max_rate_hz = 11.0;
    scan.max_gap_s = 0.5;
    scan.frame = "laser";
    return scan;
  }

  std::string path_ = testing::TempDir() + "frugal_nav_" +
                      testing::UnitTest::GetInstance()->current_test_info()->name() + ".bag";
};

void nothing(int, sensor_msgs::LaserScan&) {}

TEST_F(BagCheck, SoundBagHasNoProblems) {
  write(nothing);
  const BagReport report = check({expectScan()});
  EXPECT_TRUE(report.problems.empty()) << toText(report);
  EXPECT_EQ(report.topics.at("/scan").count, 20U);
  EXPECT_NEAR(report.topics.at("/scan").rate_hz(), 10.0, 1e-6);
}

TEST_F(BagCheck, StampThatGoesBackIsNamedWithTopicAndTime) {
  write([](int i, auto& scan) {
    if (i == 10) scan.header.stamp = ros::Time(100.7);
  });
  const std::string problem = onlyProblem();
  EXPECT_NE(problem.find("/scan at 100.700: stamp goes back by 0.200 s"), std::string::npos) << problem;
}

TEST_F(BagCheck, GapIsNamed) {
  write([](int i, auto& scan) {
    if (i >= 10) scan.header.stamp += ros::Duration(0.9);
  });
  const std::string problem = onlyProblem({expectScan()});
  EXPECT_NE(problem.find("/scan at 101.900: gap of 1.000 s"), std::string::npos) << problem;
}

TEST_F(BagCheck, ZeroStampIsNamedOnceAndCounted) {
  write([](int i, auto& scan) {
    if (i >= 15) scan.header.stamp = ros::Time();
  });
  const std::string problem = onlyProblem();
  EXPECT_NE(problem.find("stamp is zero (and 4 more such)"), std::string::npos) << problem;
}

TEST_F(BagCheck, StampsOfAnotherClockAreNamed) {
  write([](int, auto& scan) { scan.header.stamp += ros::Duration(3600.0); });
  EXPECT_NE(onlyProblem().find("stamp lies -3600.000 s before its recording"), std::string::npos);
}

TEST_F(BagCheck, MissingTopicIsNamed) {
  write(nothing);
  TopicExpectation odom;
  odom.topic = "odom";
  EXPECT_NE(onlyProblem({odom}).find("/odom: is missing"), std::string::npos);
  odom.required = false;
  EXPECT_TRUE(check({odom}).problems.empty());
}

TEST_F(BagCheck, WrongTypeRateAndFrameAreNamed) {
  write([](int, auto& scan) { scan.header.frame_id = "base_scan"; });
  EXPECT_NE(onlyProblem({expectScan()}).find("frame_id is 'base_scan', expected 'laser'"), std::string::npos);
  TopicExpectation other;
  other.topic = "scan";
  other.type = "sensor_msgs/Imu";
  EXPECT_NE(onlyProblem({other}).find("is sensor_msgs/LaserScan, expected sensor_msgs/Imu"),
            std::string::npos);
  other.type.clear();
  other.min_rate_hz = 20.0;
  EXPECT_NE(onlyProblem({other}).find("rate is 10 Hz, expected at least 20 Hz"), std::string::npos);
}

TEST_F(BagCheck, FramesThatNobodyKnowsAreNamed) {
  write(nothing);
  {
    rosbag::Bag bag(path_, rosbag::bagmode::Append);
    tf2_msgs::TFMessage tf;
    tf.transforms.resize(1);
    tf.transforms[0].header.frame_id = "odom";
    tf.transforms[0].child_frame_id = "base_link";
    bag.write("/tf", ros::Time(100.0), tf);
  }
  EXPECT_NE(onlyProblem().find("frame 'laser' is not in the bag's tf"), std::string::npos);
}

TEST_F(BagCheck, CutOffBagIsNamedAsUnindexed) {
  {
    // Chunks are flushed as they fill: enough scans that the copy below holds whole ones, but no index.
    rosbag::Bag bag(path_, rosbag::bagmode::Write);
    bag.setChunkThreshold(10000);
    for (int i = 0; i < 100; ++i) bag.write("scan", ros::Time(100.0 + 0.1 * i), scanAt(100.0 + 0.1 * i));
  }
  std::ifstream whole(path_, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(whole)), std::istreambuf_iterator<char>());
  std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes.substr(0, bytes.size() / 2);
  const std::string problem = onlyProblem();
  EXPECT_NE(problem.find("the bag:"), std::string::npos) << problem;
}

TEST_F(BagCheck, FileThatIsNoBagIsNamed) {
  std::ofstream(path_) << "not a bag";
  EXPECT_NE(onlyProblem().find("cannot be read as a bag"), std::string::npos);
  std::remove(path_.c_str());
  EXPECT_NE(onlyProblem().find("cannot be read as a bag"), std::string::npos);
}

TEST_F(BagCheck, NamespaceStandsBeforeTheNames) {
  rosbag::Bag(path_, rosbag::bagmode::Write).write("/robot1/scan", ros::Time(100.0), scanAt(100.0));
  TopicExpectation scan;
  scan.topic = "scan";
  EXPECT_FALSE(checkBag(path_, {scan}).problems.empty());
  EXPECT_TRUE(checkBag(path_, {scan}, "/robot1").problems.empty());
}

TEST_F(BagCheck, ToolTellsByItsExitStatus) {
  write(nothing);
  EXPECT_EQ(test::runProgram("validate_bag", path_ + " --topics none").exit_code, 0);
  const test::ProgramResult missing = test::runProgram("validate_bag", path_);  // by the package's list
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_NE(missing.output.find("/odom: is missing"), std::string::npos) << missing.output;
  EXPECT_EQ(test::runProgram("validate_bag", path_ + " --topic x").exit_code, 2);
}

TEST(BagTopics, NoTicksAreNeededWhereOdometryIs) {
  for (const TopicExpectation& expectation :
       readBagExpectations(std::string(FRUGAL_NAV_SOURCE_DIR) + "/config/bag_topics.yaml")) {
    if (expectation.topic == "wheel_ticks" || expectation.topic == "joint_states") {
      EXPECT_FALSE(expectation.required) << expectation.topic;
    }
    if (expectation.topic == "odom" || expectation.topic == "scan") {
      EXPECT_TRUE(expectation.required) << expectation.topic;
    }
  }
}

TEST(BagTopics, UnknownKeyIsNamed) {
  const std::string path = testing::TempDir() + "frugal_nav_topics.yaml";
  std::ofstream(path) << "topics:\n  - topic: scan\n    max_gap: 1.0\n";
  try {
    readBagExpectations(path);
    FAIL() << "an unknown key was taken";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("max_gap"), std::string::npos);
  }
  std::remove(path.c_str());
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
