#include "planning_graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nav_msgs/OccupancyGrid.h>
#include <std_msgs/String.h>
#include <visualization_msgs/MarkerArray.h>

namespace frugal_nav {
namespace {

using testing::HasSubstr;

class PlannerNodeTest : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(graph_.connect("planner") && paths_.waitForPublisher()); }
  void TearDown() override {
    graph_.stopMission();
    graph_.beat();
  }

  /// The path for a scan that is published now.
  const nav_msgs::Path& pathFor(const sensor_msgs::LaserScan& scan) {
    static const nav_msgs::Path kNone;
    graph_.publishScan(scan);
    const nav_msgs::Path* path = test::answerAt(paths_, scan.header.stamp);
    EXPECT_NE(path, nullptr) << "no path for the scan";
    return path != nullptr ? *path : kNone;
  }
  /// Beats until a scan leads to a path, or to none, as wanted: goal and scan come on different connections.
  bool beatUntilPath(bool wanted) {
    for (int i = 0; i < 50; ++i) {
      graph_.beat();
      if (pathFor(graph_.scan()).poses.empty() != wanted) return true;
    }
    return false;
  }

  test::PlanningGraph graph_;
  test::Recorder<nav_msgs::Path> paths_{graph_.nh, "path"};
};

TEST_F(PlannerNodeTest, EachScanGivesOnePathWithItsStamp) {
  graph_.driveTo({4.0, 0.5, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  const nav_msgs::Path& path = paths_.messages.back();
  EXPECT_EQ(path.header.stamp, graph_.clock.now());
  EXPECT_EQ(path.header.frame_id, "odom");
  EXPECT_NEAR(path.poses.front().pose.position.x, 0.0, 1e-9);
  EXPECT_NEAR(path.poses.back().pose.position.x, 4.0, 1e-9);
  const std::size_t before = paths_.messages.size();
  for (int i = 0; i < 5; ++i) {
    graph_.beat();
    EXPECT_FALSE(pathFor(graph_.scan()).poses.empty());
  }
  EXPECT_EQ(paths_.messages.size(), before + 5);
}

TEST_F(PlannerNodeTest, PathIsEmptyWithoutAGoal) {
  graph_.beat();
  EXPECT_TRUE(pathFor(graph_.scan()).poses.empty());
  graph_.driveTo({4.0, 0.5, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  graph_.stopMission();
  EXPECT_TRUE(beatUntilPath(false));
}

TEST_F(PlannerNodeTest, ScanWaitsForItsOdometry) {
  graph_.driveTo({4.0, 0.5, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  graph_.clock.advance(0.1);
  const sensor_msgs::LaserScan scan = graph_.scan();
  graph_.publishScan(scan);
  const std::size_t before = paths_.messages.size();
  EXPECT_FALSE(paths_.waitForCount(before + 1, 0.3));  // wall time: nothing may come
  graph_.pose = {0.2, 0.1, 0.0};
  graph_.publishOdometry();
  const nav_msgs::Path* path = test::answerAt(paths_, scan.header.stamp);
  ASSERT_NE(path, nullptr);
  EXPECT_NEAR(path->poses.front().pose.position.x, 0.2, 1e-6);  // the pose of that odometry
}

TEST_F(PlannerNodeTest, LostOdometryGivesAnEmptyPath) {
  graph_.driveTo({4.0, 0.5, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  graph_.clock.advance(0.1);
  const sensor_msgs::LaserScan scan = graph_.scan();
  graph_.publishScan(scan);
  const nav_msgs::Path* path = nullptr;
  for (int i = 0; i < 40 && path == nullptr; ++i) {
    graph_.clock.advance(0.05);  // ROS time passes, odometry does not come
    test::waitUntil([this] { return false; }, 0.02);
    for (const auto& message : paths_.messages)
      path = message.header.stamp == scan.header.stamp ? &message : path;
  }
  ASSERT_NE(path, nullptr);
  EXPECT_TRUE(path->poses.empty());
  EXPECT_GE((graph_.clock.now() - scan.header.stamp).toSec(), 0.25);
}

TEST_F(PlannerNodeTest, SurvivesBadScans) {
  graph_.driveTo({4.0, 0.5, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  const auto expectNone = [this](const sensor_msgs::LaserScan& scan) {
    EXPECT_TRUE(pathFor(scan).poses.empty());
    graph_.beat();
    EXPECT_FALSE(pathFor(graph_.scan()).poses.empty());
    graph_.beat();
  };
  graph_.beat();
  sensor_msgs::LaserScan scan = graph_.scan();
  scan.ranges.assign(scan.ranges.size(), test::kNan);
  expectNone(scan);
  scan = graph_.scan();
  scan.ranges.assign(scan.ranges.size(), 0.0F);
  expectNone(scan);
  scan = graph_.scan();
  scan.ranges.assign(scan.ranges.size(), std::numeric_limits<float>::infinity());
  expectNone(scan);
  scan = graph_.scan();
  scan.intensities.swap(scan.ranges);
  expectNone(scan);
  scan = graph_.scan();
  scan.angle_increment = 0.0F;
  expectNone(scan);
  scan = graph_.scan();
  scan.angle_increment *= 3.0F;
  expectNone(scan);
  scan = graph_.scan();
  scan.angle_increment *= 0.5F;
  expectNone(scan);
  scan = graph_.scan();
  scan.header.frame_id = "nowhere";
  expectNone(scan);
}

TEST_F(PlannerNodeTest, GoalInAnObstacleGivesNoPathAndTheReason) {
  test::Recorder<std_msgs::String> reasons(graph_.nh, "path/reason");
  graph_.world.box(2.0, -0.3, 2.3, 0.3);
  graph_.pose = {4.0, 0.0, 0.0};
  graph_.beat();
  pathFor(graph_.scan());  // its far side
  graph_.pose = {0.0, 0.0, 0.0};
  graph_.driveTo({2.15, 0.0, 0.0});
  for (int i = 0; i < 10; ++i) {
    graph_.beat();
    EXPECT_TRUE(pathFor(graph_.scan()).poses.empty());
  }
  ASSERT_TRUE(reasons.waitForCount(1));
  EXPECT_EQ(reasons.messages.back().data, "the goal lies in an obstacle");
  graph_.driveTo({3.5, 0.0, 0.0});  // behind it
  EXPECT_TRUE(beatUntilPath(true));
}

TEST_F(PlannerNodeTest, StampThatGoesBackStartsAnew) {
  graph_.driveTo({4.0, 0.5, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  const ros::Time before = graph_.clock.now();
  graph_.clock.set(before - ros::Duration(50.0));
  graph_.world = planning_test::FlatWorld().box(-1.0, -2.5, 6.0, 2.5);
  graph_.driveTo({3.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  EXPECT_LT(paths_.messages.back().header.stamp, before);
  EXPECT_NEAR(paths_.messages.back().poses.back().pose.position.x, 3.0, 1e-9);
}

TEST_F(PlannerNodeTest, ShowsGridAndMarkersToListeners) {
  test::Recorder<nav_msgs::OccupancyGrid> grids(graph_.nh, "grid");
  test::Recorder<visualization_msgs::MarkerArray> markers(graph_.nh, "planner/markers");
  ASSERT_TRUE(grids.waitForPublisher() && markers.waitForPublisher());
  graph_.driveTo({4.0, 0.5, 0.0});
  // Both connections may take a few scans to stand.
  for (int i = 0; i < 100 && (grids.messages.size() < 2 || markers.messages.empty()); ++i) {
    graph_.beat();
    pathFor(graph_.scan());
  }
  ASSERT_GE(grids.messages.size(), 2U);
  ASSERT_FALSE(markers.messages.empty());
  const visualization_msgs::Marker& moving = markers.messages.back().markers.back();
  EXPECT_EQ(moving.ns, "moving");
  EXPECT_EQ(moving.action, visualization_msgs::Marker::DELETE) << "nothing moves here";
  const nav_msgs::OccupancyGrid& grid = grids.messages.back();
  EXPECT_GE((grid.header.stamp - grids.messages[grids.messages.size() - 2].header.stamp).toSec(), 0.5 - 1e-6);
  ASSERT_EQ(grid.data.size(), grid.info.width * grid.info.height);
  const auto at = [&grid](double x, double y) {
    const auto column = static_cast<std::size_t>((x - grid.info.origin.position.x) / grid.info.resolution);
    const auto row = static_cast<std::size_t>((y - grid.info.origin.position.y) / grid.info.resolution);
    return static_cast<int>(grid.data[row * grid.info.width + column]);
  };
  EXPECT_EQ(at(1.0, 0.0), 0);
  EXPECT_EQ(at(-1.001, 0.02), 100);
  EXPECT_EQ(at(-2.0, 0.0), -1);
}

TEST(PlannerNodeStart, NamesAnUnknownParameter) {
  const test::ProgramResult result =
      test::runProgram("planner_node", "__name:=bad_planner _goal_tolerance:=0.1");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output,
              HasSubstr("unknown parameter \"goal_tolerance\"; did you mean \"goal_tolerance_m\"?"));
  ros::param::del("bad_planner");
}

TEST(PlannerNodeStart, NamesAWrongType) {
  const test::ProgramResult result =
      test::runProgram("planner_node", "__name:=bad_planner _path_spacing_m:=wide");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("\"path_spacing_m\" must be a number"));
  ros::param::del("bad_planner");
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "planner_node_test");
  ros::NodeHandle nh;  // keeps ROS running between the tests
  return RUN_ALL_TESTS();
}
