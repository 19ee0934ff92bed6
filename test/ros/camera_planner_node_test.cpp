#include "planning_graph.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nav_msgs/OccupancyGrid.h>
#include <visualization_msgs/MarkerArray.h>

#include <frugal_nav/Gap.h>
#include <frugal_nav/Obstacle.h>

namespace frugal_nav {
namespace {

using testing::HasSubstr;

/// A robot at the origin of a walled room, and what depth_gap would say of its images.
class CameraPlannerNodeTest : public testing::Test {
 protected:
  void SetUp() override {
    gap_pub_ = nh_.advertise<Gap>("gap", 10);
    obstacle_pub_ = nh_.advertise<Obstacle>("obstacle/nearest", 10);
    scan_pub_ = nh_.advertise<sensor_msgs::LaserScan>("depth/scan", 10);
    odometry_pub_ = nh_.advertise<nav_msgs::Odometry>("odom", 10);
    state_pub_ = nh_.advertise<MissionState>("mission/state", 10, true);
    goal_pub_ = nh_.advertise<geometry_msgs::PoseStamped>("mission/goal", 1, true);
    observed_pub_ = nh_.advertise<geometry_msgs::PoseWithCovarianceStamped>("goal/observed", 10);
    for (const ros::Publisher* publisher :
         {&gap_pub_, &obstacle_pub_, &scan_pub_, &odometry_pub_, &state_pub_, &goal_pub_, &observed_pub_})
      ASSERT_TRUE(test::waitForSubscriber(*publisher));
    ASSERT_TRUE(paths_.waitForPublisher());
  }
  void TearDown() override {
    mission_.mode = Mode::kIdle;
    mission_.phase = MissionPhase::kCancelled;
    beat();
  }

  void driveTo(const Pose2& goal) {
    geometry_msgs::PoseStamped msg;
    msg.header.stamp = clock_.now();
    msg.header.frame_id = "odom";
    msg.pose = toRos(goal);
    goal_pub_.publish(msg);
    mission_.mode = Mode::kCamera;
    mission_.phase = MissionPhase::kDriving;
    ++mission_.goal_number;
  }

  /// A fifth of a second later: mission state and odometry of the new time.
  void beat() {
    clock_.advance(0.2);
    mission_.stamp = toStamp(clock_.now());
    state_pub_.publish(toRos(mission_));
    Odometry odometry;
    odometry.stamp = mission_.stamp;
    odometry_pub_.publish(toRos(odometry, "odom", "base_link"));
  }

  Gap gap() const {
    GapSighting gap;
    gap.stamp = toStamp(clock_.now());
    gap.found = true;
    gap.p_odom = {1.5, 0.0};
    return toRos(gap, "odom");
  }
  Obstacle obstacle() const {
    NearestObstacle none;
    none.stamp = toStamp(clock_.now());
    return toRos(none, "odom");
  }
  sensor_msgs::LaserScan scan() const {
    LaserScan seen = world_.scan({}, toSeconds(toStamp(clock_.now())));
    // The camera's part of it: 31 degrees to each side.
    seen.ranges_m = {seen.ranges_m.begin() + 149, seen.ranges_m.begin() + 212};
    seen.angle_min_rad = seen.angleOf(149);
    return toRos(seen, "base_link");
  }
  /// The path for an image of the present time.
  const nav_msgs::Path& pathForImage() {
    static const nav_msgs::Path kNone;
    gap_pub_.publish(gap());
    obstacle_pub_.publish(obstacle());
    scan_pub_.publish(scan());
    const nav_msgs::Path* path = test::answerAt(paths_, clock_.now());
    EXPECT_NE(path, nullptr) << "no path for the image";
    return path != nullptr ? *path : kNone;
  }
  /// Beats until an image leads to a path, or to none, as wanted: goal and image come on different
  /// connections.
  bool beatUntilPath(bool wanted) {
    for (int i = 0; i < 50; ++i) {
      beat();
      if (pathForImage().poses.empty() != wanted) return true;
    }
    return false;
  }
  void see(double x, double y) {
    geometry_msgs::PoseWithCovarianceStamped msg;
    msg.header.stamp = clock_.now();
    msg.header.frame_id = "odom";
    msg.pose.pose.position.x = x;
    msg.pose.pose.position.y = y;
    msg.pose.pose.orientation.w = 1.0;
    observed_pub_.publish(msg);
  }
  static double farthestAside(const nav_msgs::Path& path) {
    double aside = 0.0;
    for (const auto& pose : path.poses) aside = std::max(aside, std::abs(pose.pose.position.y));
    return aside;
  }

  ros::NodeHandle nh_;
  test::TestClock clock_{nh_};
  planning_test::FlatWorld world_ = planning_test::FlatWorld().box(-1.0, -2.5, 6.0, 2.5);
  MissionStatus mission_;
  ros::Publisher gap_pub_, obstacle_pub_, scan_pub_, odometry_pub_, state_pub_, goal_pub_, observed_pub_;
  test::Recorder<nav_msgs::Path> paths_{nh_, "path"};
};

TEST_F(CameraPlannerNodeTest, EachImageGivesOnePathWithItsStamp) {
  beat();
  EXPECT_TRUE(pathForImage().poses.empty());  // no goal
  driveTo({3.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  const nav_msgs::Path& path = paths_.messages.back();
  EXPECT_EQ(path.header.stamp, clock_.now());
  EXPECT_EQ(path.header.frame_id, "odom");
  EXPECT_NEAR(path.poses.back().pose.position.x, 3.0, 1e-6);
  const std::size_t before = paths_.messages.size();
  for (int i = 0; i < 5; ++i) {
    beat();
    EXPECT_FALSE(pathForImage().poses.empty());
  }
  EXPECT_EQ(paths_.messages.size(), before + 5);
}

TEST_F(CameraPlannerNodeTest, DrivesAroundWhatItSees) {
  world_.box(1.3, -0.2, 1.6, 0.2);
  driveTo({3.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  EXPECT_GT(farthestAside(paths_.messages.back()), 0.3);
}

TEST_F(CameraPlannerNodeTest, DoesNotTakeThePersonForAnObstacle) {
  world_.box(2.8, -0.2, 3.1, 0.2);  // stands where the goal leads to, 0.3 m behind it
  driveTo({2.5, 0.0, 0.0});
  for (int i = 0; i < 20; ++i) {
    see(3.0, 0.0);
    beat();
    pathForImage();
  }
  ASSERT_FALSE(paths_.messages.back().poses.empty());
  EXPECT_NEAR(paths_.messages.back().poses.back().pose.position.x, 2.5, 1e-6);
}

TEST_F(CameraPlannerNodeTest, AnImageWithoutItsOtherHalvesGivesAnEmptyPath) {
  driveTo({3.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  beat();
  const ros::Time stamp = clock_.now();
  gap_pub_.publish(gap());
  const nav_msgs::Path* path = nullptr;
  for (int i = 0; i < 40 && path == nullptr; ++i) {
    clock_.advance(0.05);
    test::waitUntil([this] { return false; }, 0.02);
    for (const auto& message : paths_.messages) path = message.header.stamp == stamp ? &message : path;
  }
  ASSERT_NE(path, nullptr);
  EXPECT_TRUE(path->poses.empty());
  EXPECT_TRUE(beatUntilPath(true));
}

TEST_F(CameraPlannerNodeTest, SurvivesBadInput) {
  driveTo({3.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  const auto expectNone = [this](const Gap& gap, const Obstacle& obstacle,
                                 const sensor_msgs::LaserScan& scan) {
    gap_pub_.publish(gap);
    obstacle_pub_.publish(obstacle);
    scan_pub_.publish(scan);
    const nav_msgs::Path* path = test::answerAt(paths_, clock_.now());
    ASSERT_NE(path, nullptr);
    EXPECT_TRUE(path->poses.empty());
    beat();
    EXPECT_FALSE(pathForImage().poses.empty());
    beat();
  };
  beat();
  Gap bad_gap = gap();
  bad_gap.node.x = test::kNan;
  expectNone(bad_gap, obstacle(), scan());
  Obstacle useless = obstacle();
  useless.reason = "the image is dark";
  expectNone(gap(), useless, scan());
  sensor_msgs::LaserScan unknown = scan();
  unknown.ranges.assign(unknown.ranges.size(), test::kNan);
  expectNone(gap(), obstacle(), unknown);
  sensor_msgs::LaserScan elsewhere = scan();
  elsewhere.header.frame_id = "laser";
  expectNone(gap(), obstacle(), elsewhere);
}

TEST_F(CameraPlannerNodeTest, StampThatGoesBackStartsAnew) {
  driveTo({3.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  const ros::Time before = clock_.now();
  clock_.set(before - ros::Duration(50.0));
  driveTo({2.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  EXPECT_LT(paths_.messages.back().header.stamp, before);
  EXPECT_NEAR(paths_.messages.back().poses.back().pose.position.x, 2.0, 1e-6);
}

TEST_F(CameraPlannerNodeTest, ShowsGridAndNodesToListeners) {
  test::Recorder<nav_msgs::OccupancyGrid> grids(nh_, "grid");
  test::Recorder<visualization_msgs::MarkerArray> markers(nh_, "planner/markers");
  ASSERT_TRUE(grids.waitForPublisher() && markers.waitForPublisher());
  driveTo({3.0, 0.0, 0.0});
  ASSERT_TRUE(beatUntilPath(true));
  ASSERT_TRUE(grids.waitForCount(1) && markers.waitForCount(1));
  std::vector<std::string> shown;
  for (const auto& marker : markers.messages.back().markers) shown.push_back(marker.ns);
  EXPECT_THAT(shown, testing::UnorderedElementsAre("path", "robot", "goal", "gap", "obstacle", "moving",
                                                   "names", "names", "names"));
}

TEST(CameraPlannerNodeStart, RefusesTheOtherModesParameters) {
  const test::ProgramResult result =
      test::runProgram("planner_node", "__name:=bad_planner _mode:=camera _scan/keep_s:=1.0");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("unknown parameter"));
  ros::param::del("bad_planner");
}

TEST(CameraPlannerNodeStart, RefusesAnUnknownMode) {
  const test::ProgramResult result = test::runProgram("planner_node", "__name:=bad_planner _mode:=radar");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("mode"));
  ros::param::del("bad_planner");
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "camera_planner_node_test");
  ros::NodeHandle nh;  // keeps ROS running between the tests
  return RUN_ALL_TESTS();
}
