// Reads a drive recorded from the simulator and runs wheel odometry and avoidance over it, in this process.

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <frugal_nav/WheelTicks.h>
#include <frugal_nav/common/odometry_buffer.hpp>
#include <frugal_nav/odometry/wheel_odometry.hpp>
#include <frugal_nav/planning/lidar_avoidance.hpp>
#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/robot/robot_model.hpp>
#include <frugal_nav/ros/bag_check.hpp>
#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/planning_params.hpp>
#include <frugal_nav/ros/wheel_odometry_params.hpp>

namespace frugal_nav {
namespace {

const std::string kSource = FRUGAL_NAV_SOURCE_DIR;
const std::string kBag = kSource + "/test/data/lab_drive.bag";

/// All messages of one topic.
template <class Message>
std::vector<Message> readTopic(const std::string& topic) {
  rosbag::Bag bag(kBag);
  rosbag::View view(bag, rosbag::TopicQuery(std::vector<std::string>{topic, "/" + topic}));
  std::vector<Message> messages;
  for (const rosbag::MessageInstance& instance : view) messages.push_back(*instance.instantiate<Message>());
  return messages;
}

RobotModel robot() { return loadRobot(kSource + "/urdf/frugal_bot.urdf"); }

/// The odometry of the bag's ticks; by default with the parameters it was recorded with, which are
/// uncalibrated.
std::vector<Odometry> runWheelOdometry(const WheelOdometryParams& params = {}) {
  const DriveGeometry drive = robot().drive;
  WheelOdometry wheels(params, {drive.radius_m, drive.separation_m});
  std::vector<Odometry> odometry;
  for (const WheelTicks& ticks : readTopic<WheelTicks>("wheel_ticks")) {
    if (const auto result = wheels.addTicks(toStamp(ticks.header.stamp), ticks.left, ticks.right))
      odometry.push_back(*result);
  }
  return odometry;
}

TEST(LabDrive, BagIsSound) {
  const BagReport report = checkBag(kBag, readBagExpectations(kSource + "/config/bag_topics.yaml"));
  EXPECT_TRUE(report.problems.empty()) << toText(report);
}

TEST(LabDrive, WheelOdometryStaysNearTheTruth) {
  std::map<Stamp, Pose2> truth;
  for (const nav_msgs::Odometry& msg : readTopic<nav_msgs::Odometry>("ground_truth/odom"))
    truth[toStamp(msg.header.stamp)] = fromRos(msg)->odom_from_base;
  auto params = loadParamFile<WheelOdometryNodeParams>(kSource + "/config/wheel_odometry.yaml");
  const std::string calibration = kSource + "/config/simulated/wheel_odometry.yaml";
  assign(readParamFile(calibration), calibration, params);
  const std::vector<Odometry> odometry = runWheelOdometry(params.odometry);
  ASSERT_GT(odometry.size(), 700U);  // 15 s at 50 Hz

  const Pose2 start_from_world = truth.at(odometry.front().stamp).inverse();
  double length_m = 0.0;
  double worst_m = 0.0;
  Pose2 last;
  for (const Odometry& estimate : odometry) {
    const Pose2 true_pose = start_from_world * truth.at(estimate.stamp);
    length_m += distance(last, true_pose);
    last = true_pose;
    worst_m = std::max(worst_m, distance(true_pose, estimate.odom_from_base));
  }
  EXPECT_GT(length_m, 4.0);
  // The slip's random part turns the robot by 2.6 degrees rms over such a drive (evaluate lidar); twice that,
  // growing evenly over the way, displaces its end by 4.5 % of the way.
  EXPECT_LT(worst_m, 0.045 * length_m);
}

TEST(LabDrive, WheelOdometryRepeatsTheNode) {
  std::map<Stamp, Pose2> recorded;
  for (const nav_msgs::Odometry& msg : readTopic<nav_msgs::Odometry>("odom"))
    recorded[toStamp(msg.header.stamp)] = fromRos(msg)->odom_from_base;
  for (const Odometry& estimate : runWheelOdometry()) {
    const auto found = recorded.find(estimate.stamp);
    ASSERT_NE(found, recorded.end());
    ASSERT_LT(distance(found->second, estimate.odom_from_base), 1e-9);
  }
}

/// The commands of avoidance over the whole bag, each with the scan it rests on.
struct AvoidanceRun {
  struct Step {
    LaserScan scan;
    Pose2 odom_from_base;
    MotionCommand command;
  };
  std::vector<Step> steps;
  Pose2 base_from_laser;
};

AvoidanceRun runAvoidance(const std::string& method) {
  const RobotModel model = robot();
  auto params = loadParamFile<LidarAvoidanceNodeParams>(kSource + "/config/lidar_avoidance.yaml").avoidance;
  params.method = method;
  LidarAvoidance avoidance(params, {model.halfWidth_m(), model.circumradius_m()});
  avoidance.setGoal(planar(readTopic<geometry_msgs::PoseStamped>("mission/goal").at(0).pose));

  std::map<Stamp, Path2> paths;
  for (const nav_msgs::Path& path : readTopic<nav_msgs::Path>("path"))
    paths[toStamp(path.header.stamp)] = *fromRos(path);
  OdometryBuffer buffer(fromSeconds(60.0));
  for (const Odometry& odometry : runWheelOdometry()) buffer.add(odometry);

  AvoidanceRun run;
  run.base_from_laser = model.planarBaseFrom("laser");
  for (const sensor_msgs::LaserScan& msg : readTopic<sensor_msgs::LaserScan>("scan")) {
    const LaserScan scan = fromRos(msg);
    const auto odometry = buffer.at(scan.stamp);
    const auto path = paths.find(scan.stamp);
    if (!odometry || path == paths.end()) continue;
    avoidance.setPath(scan.stamp, path->second);
    run.steps.push_back(
        {scan, odometry->odom_from_base, avoidance.update(scan, run.base_from_laser, *odometry)});
  }
  return run;
}

TEST(LabDrive, AvoidanceAnswersEveryScanAndIsSeldomBlocked) {
  for (const char* method : {"sectors", "vfh_plus", "vfh_star", "dwa"}) {
    const AvoidanceRun run = runAvoidance(method);
    EXPECT_EQ(run.steps.size(), readTopic<sensor_msgs::LaserScan>("scan").size());
    // Scans after the goal was reached, and those before it was set, have an empty path: "blocked" is right
    // there.
    const auto driving =
        std::count_if(run.steps.begin(), run.steps.end(), [](const AvoidanceRun::Step& step) {
          return step.command.status == MotionCommand::Status::kDriving;
        });
    EXPECT_GT(static_cast<double>(driving), 0.9 * static_cast<double>(run.steps.size())) << method;
  }
}

TEST(LabDrive, AvoidanceAimsWhereTheBodyFits) {
  const AvoidanceRun run = runAvoidance("sectors");
  double least_m = 10.0;
  for (const AvoidanceRun::Step& step : run.steps) {
    if (step.command.holds != MotionCommand::Holds::kTarget) continue;
    const Eigen::Vector2d target = step.odom_from_base.inverse() * step.command.odom_from_target.position();
    for (const Eigen::Vector2d& obstacle : obstaclePoints(step.scan, run.base_from_laser))
      least_m = std::min(least_m, (obstacle - target).norm());
  }
  // Half the body's width is 0.125 m; the narrowest blocking leaves 0.04 m beside it.
  EXPECT_GT(least_m, 0.125 + 0.04);
  RecordProperty("least_target_clearance_mm", static_cast<int>(1000.0 * least_m));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
