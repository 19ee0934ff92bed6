#include "planning_graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <visualization_msgs/MarkerArray.h>

#include <frugal_nav/LocalCommand.h>

namespace frugal_nav {
namespace {

using testing::HasSubstr;

class LidarAvoidanceNodeTest : public testing::Test {
 protected:
  /// The method that drives, as the .test file has set it.
  static std::string method() { return ros::param::param<std::string>("lidar_avoidance/method", "vfh_star"); }

  void SetUp() override {
    path_pub_ = graph_.nh.advertise<nav_msgs::Path>("path", 10);
    ASSERT_TRUE(graph_.connect("lidar_avoidance") && commands_.waitForPublisher() &&
                test::waitForSubscriber(path_pub_));
  }
  void TearDown() override {
    graph_.stopMission();
    graph_.beat();
  }

  void publishPath(double length_m = 4.0) {
    Path2 path;
    for (double x = 0.0; x <= length_m; x += 0.1) path.push_back({x, 0.0, 0.0});
    path_pub_.publish(toRos(path, toStamp(graph_.clock.now()), "odom"));
  }
  const LocalCommand& commandFor(const sensor_msgs::LaserScan& scan) {
    static const LocalCommand kNone;
    graph_.publishScan(scan);
    const LocalCommand* command = test::answerAt(commands_, scan.header.stamp);
    EXPECT_NE(command, nullptr) << "no command for the scan";
    return command != nullptr ? *command : kNone;
  }
  /// Beats with scan and path until the node drives: goal and scan come on different connections.
  bool beatUntilDriving() {
    for (int i = 0; i < 50; ++i) {
      graph_.beat();
      publishPath();
      if (commandFor(graph_.scan()).status == LocalCommand::STATUS_DRIVING) return true;
    }
    return false;
  }
  /// Lets ROS time pass without any input until the scan of that stamp is answered.
  const LocalCommand* answerLater(ros::Time stamp) {
    for (int i = 0; i < 60; ++i) {
      for (const LocalCommand& command : commands_.messages) {
        if (command.header.stamp == stamp) return &command;
      }
      graph_.clock.advance(0.05);
      test::waitUntil([] { return false; }, 0.02);
    }
    return nullptr;
  }

  test::PlanningGraph graph_;
  test::Recorder<LocalCommand> commands_{graph_.nh, "avoidance/command"};
  ros::Publisher path_pub_;
};

TEST_F(LidarAvoidanceNodeTest, ACommandHasTheNumberOfItsGoal) {
  graph_.driveTo({4.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilDriving());
  EXPECT_EQ(commands_.messages.back().goal_number, graph_.mission.goal_number);
  // The state of the next goal comes before the goal itself: the old one must not be driven to in its name.
  ++graph_.mission.goal_number;
  const bool next = test::waitUntil([this] {
    graph_.beat();
    publishPath();
    return commandFor(graph_.scan()).goal_number == graph_.mission.goal_number;
  });
  ASSERT_TRUE(next);
  EXPECT_EQ(commands_.messages.back().status, LocalCommand::STATUS_IDLE);
  --graph_.mission.goal_number;
  graph_.driveTo({4.0, 0.0, 0.0});
  EXPECT_TRUE(beatUntilDriving());
}

TEST_F(LidarAvoidanceNodeTest, IdleWithoutGoalForEachScan) {
  for (int i = 0; i < 3; ++i) {
    graph_.beat();
    const LocalCommand& command = commandFor(graph_.scan());
    EXPECT_EQ(command.status, LocalCommand::STATUS_IDLE);
    EXPECT_EQ(command.holds, LocalCommand::HOLDS_NOTHING);
    EXPECT_EQ(command.header.stamp, graph_.clock.now());
    EXPECT_EQ(command.header.frame_id, "odom");
  }
  EXPECT_EQ(commands_.messages.size(), 3U);
}

TEST_F(LidarAvoidanceNodeTest, DrivesAlongThePath) {
  graph_.driveTo({4.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilDriving());
  const LocalCommand& command = commands_.messages.back();
  if (method() != "sectors") {
    EXPECT_EQ(command.holds, LocalCommand::HOLDS_VELOCITY);
    EXPECT_GT(command.v_mps, 0.0);
    return;
  }
  EXPECT_EQ(command.holds, LocalCommand::HOLDS_TARGET);
  EXPECT_NEAR(command.target.position.x, 0.5, 1e-6);
  EXPECT_NEAR(command.target.position.y, 0.0, 1e-6);
}

TEST_F(LidarAvoidanceNodeTest, ScanWaitsForThePathThatRestsOnIt) {
  graph_.driveTo({4.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilDriving());
  graph_.beat();
  const sensor_msgs::LaserScan scan = graph_.scan();
  graph_.publishScan(scan);
  const std::size_t before = commands_.messages.size();
  EXPECT_FALSE(commands_.waitForCount(before + 1, 0.3));  // wall time: nothing may come
  publishPath();
  const LocalCommand* command = test::answerAt(commands_, scan.header.stamp);
  ASSERT_NE(command, nullptr);
  EXPECT_EQ(command->status, LocalCommand::STATUS_DRIVING);
}

TEST_F(LidarAvoidanceNodeTest, StopsWhenThePlannerIsSilent) {
  graph_.driveTo({4.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilDriving());
  // Scans and odometry go on, paths do not.
  ros::Time first;
  for (int i = 0; i < 12; ++i) {
    graph_.beat();
    graph_.publishScan(graph_.scan());
    if (i == 0) first = graph_.clock.now();
    test::waitUntil([] { return false; }, 0.02);
  }
  const LocalCommand* command = answerLater(first + ros::Duration(0.5));
  ASSERT_NE(command, nullptr);
  EXPECT_EQ(command->status, LocalCommand::STATUS_STOPPED);
  EXPECT_EQ(command->holds, LocalCommand::HOLDS_NOTHING);
  EXPECT_EQ(command->reason, "no path from the planner for 0.60 s");
}

TEST_F(LidarAvoidanceNodeTest, StopsWithoutOdometry) {
  graph_.driveTo({4.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilDriving());
  graph_.clock.advance(0.1);
  publishPath();
  const sensor_msgs::LaserScan scan = graph_.scan();
  graph_.publishScan(scan);
  const LocalCommand* command = answerLater(scan.header.stamp);
  ASSERT_NE(command, nullptr);
  EXPECT_EQ(command->status, LocalCommand::STATUS_STOPPED);
  EXPECT_EQ(command->reason, "no odometry for the scan's stamp");
}

TEST_F(LidarAvoidanceNodeTest, NamesWhatIsWrongWithAScan) {
  graph_.driveTo({4.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilDriving());
  const auto expectStop = [this](const sensor_msgs::LaserScan& scan, const std::string& reason) {
    const LocalCommand command = commandFor(scan);
    EXPECT_EQ(command.status, LocalCommand::STATUS_STOPPED);
    EXPECT_EQ(command.holds, LocalCommand::HOLDS_NOTHING);
    EXPECT_EQ(command.reason, reason);
    EXPECT_TRUE(beatUntilDriving());
    graph_.beat();
  };
  graph_.beat();
  sensor_msgs::LaserScan scan = graph_.scan();
  const std::size_t beams = scan.ranges.size();
  scan.ranges.assign(beams, test::kNan);
  expectStop(scan, "every range is NaN or beyond range_max");
  scan = graph_.scan();
  scan.ranges.assign(beams, 0.0F);
  expectStop(scan,
             "every range is below range_min: the laser is covered, or its driver sends zeros for failed "
             "echoes");
  scan = graph_.scan();
  scan.ranges.assign(beams, std::numeric_limits<float>::infinity());
  expectStop(scan,
             "it has no return at all: the laser is covered, or the place larger than its range (then set "
             "scan/require_return to false)");
  scan = graph_.scan();
  scan.intensities.swap(scan.ranges);
  expectStop(scan, "the scan is empty");
  scan = graph_.scan();
  scan.angle_increment = 0.0F;
  expectStop(scan, "angle_increment is zero");
  scan = graph_.scan();
  scan.angle_increment *= 3.0F;
  expectStop(scan, "the scan covers more than 360 degrees");
  scan = graph_.scan();
  scan.angle_increment *= 0.5F;
  expectStop(scan, "angle_increment and the number of ranges do not lead from angle_min to angle_max");
  scan = graph_.scan();
  scan.header.frame_id = "nowhere";
  expectStop(scan, "no transform from base_link to nowhere");
}

TEST_F(LidarAvoidanceNodeTest, StampThatGoesBackStartsAnew) {
  graph_.driveTo({4.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilDriving());
  graph_.clock.set(graph_.clock.now() - ros::Duration(50.0));
  graph_.driveTo({3.0, 0.0, 0.0});
  // The path of the time before must not be followed.
  graph_.beat();
  const sensor_msgs::LaserScan scan = graph_.scan();
  graph_.publishScan(scan);
  const LocalCommand* command = answerLater(scan.header.stamp);
  ASSERT_NE(command, nullptr);
  EXPECT_NE(command->status, LocalCommand::STATUS_DRIVING);
  EXPECT_TRUE(beatUntilDriving());
}

TEST_F(LidarAvoidanceNodeTest, ShowsTheSectorsToListeners) {
  test::Recorder<visualization_msgs::MarkerArray> markers(graph_.nh, "avoidance/markers");
  ASSERT_TRUE(markers.waitForPublisher());
  graph_.driveTo({4.0, 0.0, 0.0});
  for (int i = 0; i < 100 && markers.messages.empty(); ++i) ASSERT_TRUE(beatUntilDriving());
  ASSERT_FALSE(markers.messages.empty());
  const auto& ring = markers.messages.back().markers.front();
  EXPECT_EQ(ring.header.frame_id, "base_link");
  EXPECT_EQ(ring.points.size(), 72U * 6U);
  EXPECT_EQ(ring.colors.size(), ring.points.size());
}

TEST(LidarAvoidanceNodeStart, NamesAnUnknownMethod) {
  const test::ProgramResult result =
      test::runProgram("lidar_avoidance_node", "__name:=bad_avoidance _method:=magic");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("method = \"magic\" is none of sectors"));
  ros::param::del("bad_avoidance");
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "lidar_avoidance_node_test");
  ros::NodeHandle nh;  // keeps ROS running between the tests
  return RUN_ALL_TESTS();
}
