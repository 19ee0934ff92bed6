#include "support/ros_test.hpp"

#include <chrono>
#include <cmath>
#include <future>
#include <limits>
#include <string>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/Twist.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <std_msgs/UInt32.h>
#include <std_srvs/Trigger.h>

#include <frugal_nav/Contact.h>
#include <frugal_nav/LoadWorld.h>
#include <frugal_nav/ResetPose.h>
#include <frugal_nav/SetSeed.h>
#include <frugal_nav/StepSimulation.h>
#include <frugal_nav/WheelTicks.h>

namespace frugal_nav {
namespace {

using test::Recorder;
using test::waitUntil;
using testing::HasSubstr;

/// A running simulator in wall.world, its robot at the start.
class SimulatorNode : public testing::Test {
 protected:
  void SetUp() override {
    command_ = nh_.advertise<geometry_msgs::Twist>("cmd_vel", 10);
    ASSERT_TRUE(test::waitForSubscriber(command_));
    ASSERT_TRUE(ros::service::waitForService("simulator/resume", 10000));
    std_srvs::Trigger resume;
    ASSERT_TRUE(ros::service::call("simulator/resume", resume));
    ASSERT_TRUE(placeAt(0.0, 0.0, 0.0).success);
    ASSERT_TRUE(clock_.waitForCount(1));
    ASSERT_TRUE(truth_.waitForCount(1));
  }

  ResetPose::Response placeAt(double x_m, double y_m, double yaw_rad) {
    ResetPose reset;
    reset.request.x_m = x_m;
    reset.request.y_m = y_m;
    reset.request.yaw_rad = yaw_rad;
    EXPECT_TRUE(ros::service::call("simulator/reset_pose", reset));
    return reset.response;
  }

  StepSimulation::Response step(double seconds) {
    StepSimulation service;
    service.request.seconds = seconds;
    EXPECT_TRUE(ros::service::call("simulator/step", service));
    return service.response;
  }

  /// Holds a command until the condition is true.
  bool drive(double v_mps, double w_radps, const std::function<bool()>& until) {
    geometry_msgs::Twist twist;
    twist.linear.x = v_mps;
    twist.angular.z = w_radps;
    ros::WallTime next;
    return waitUntil([&] {
      if (ros::WallTime::now() > next) {
        command_.publish(twist);
        next = ros::WallTime::now() + ros::WallDuration(0.01);
      }
      return until();
    });
  }

  ros::Time now() const { return clock_.messages.back().clock; }
  double x_m() const { return truth_.messages.back().pose.pose.position.x; }
  double speed_mps() const { return truth_.messages.back().twist.twist.linear.x; }

  ros::NodeHandle nh_;
  ros::Publisher command_;
  Recorder<rosgraph_msgs::Clock> clock_{nh_, "/clock"};
  Recorder<nav_msgs::Odometry> truth_{nh_, "ground_truth/odom"};
};

TEST_F(SimulatorNode, PublishesEverySensorInItsFrame) {
  Recorder<WheelTicks> ticks(nh_, "wheel_ticks");
  Recorder<sensor_msgs::Imu> imu(nh_, "imu/data_raw");
  Recorder<sensor_msgs::LaserScan> scans(nh_, "scan");
  ASSERT_TRUE(ticks.waitForCount(50) && imu.waitForCount(100) && scans.waitForCount(5));
  EXPECT_EQ((ticks.messages[20].header.stamp - ticks.messages[10].header.stamp).toSec(), 0.2);
  EXPECT_EQ((imu.messages[20].header.stamp - imu.messages[10].header.stamp).toSec(), 0.1);
  EXPECT_EQ(imu.messages[0].header.frame_id, "imu_link");
  EXPECT_EQ(imu.messages[0].orientation_covariance[0], -1.0);
  const sensor_msgs::LaserScan& scan = scans.messages.back();
  EXPECT_EQ(scan.header.frame_id, "laser");
  ASSERT_EQ(scan.ranges.size(), 360U);
  EXPECT_NEAR(scan.angle_max, scan.angle_min + 359.0F * scan.angle_increment, 1e-5);
  EXPECT_NEAR(scan.scan_time,
              (scan.header.stamp - scans.messages[scans.messages.size() - 2].header.stamp).toSec(), 1e-6);
  // Ahead, from the laser 0.02 m before base_link; 1 % noise, five sigma.
  float nearest_ahead = std::numeric_limits<float>::infinity();
  for (int beam = 178; beam <= 182; ++beam) {
    if (scan.ranges[static_cast<std::size_t>(beam)] < nearest_ahead)
      nearest_ahead = scan.ranges[static_cast<std::size_t>(beam)];
  }
  EXPECT_NEAR(nearest_ahead, 1.98, 0.1);
}

TEST_F(SimulatorNode, RendersTheCameraWhileSomeoneListens) {
  Recorder<sensor_msgs::Image> images(nh_, "camera/image_raw");
  Recorder<sensor_msgs::CameraInfo> infos(nh_, "camera/camera_info");
  ASSERT_TRUE(images.waitForCount(3) && infos.waitForCount(3));
  EXPECT_EQ(images.messages[0].width, 160U);
  EXPECT_EQ(images.messages[0].encoding, "bgr8");
  EXPECT_EQ(images.messages[0].header.frame_id, "camera_optical_frame");
  EXPECT_EQ(infos.messages[0].width, 160U);
  EXPECT_GT(infos.messages[0].K[0], 100.0);
}

TEST_F(SimulatorNode, DrivesOnCommandsAndStopsWithoutThem) {
  ASSERT_TRUE(drive(0.3, 0.0, [this] { return speed_mps() > 0.25; }));
  EXPECT_TRUE(waitUntil([this] { return std::abs(speed_mps()) < 1e-3; }));
  EXPECT_GT(x_m(), 0.0);
}

TEST_F(SimulatorNode, RefusesACommandThatIsNoNumberAndStops) {
  Recorder<diagnostic_msgs::DiagnosticArray> diagnostics(nh_, "/diagnostics");
  ASSERT_TRUE(diagnostics.waitForPublisher());
  ASSERT_TRUE(drive(0.3, 0.0, [this] { return speed_mps() > 0.25; }));
  geometry_msgs::Twist bad;
  bad.linear.x = std::numeric_limits<double>::quiet_NaN();
  command_.publish(bad);
  EXPECT_TRUE(waitUntil([this] { return std::abs(speed_mps()) < 1e-3; }));
  const auto counted = [&diagnostics] {
    for (const auto& array : diagnostics.messages) {
      for (const auto& status : array.status) {
        for (const auto& value : status.values) {
          if (value.key == "cmd_vel refused" && std::stoi(value.value) >= 1) return true;
        }
      }
    }
    return false;
  };
  EXPECT_TRUE(waitUntil(counted));
}

TEST_F(SimulatorNode, PausesAndSteps) {
  EXPECT_FALSE(step(0.1).success) << "it runs";
  std_srvs::Trigger pause;
  ASSERT_TRUE(ros::service::call("simulator/pause", pause));
  const std::size_t count = clock_.messages.size();
  ASSERT_TRUE(clock_.waitForCount(count + 5));  // the value is repeated
  const ros::Time paused_at = now();
  ASSERT_TRUE(clock_.waitForCount(clock_.messages.size() + 3));
  EXPECT_EQ(now(), paused_at);
  EXPECT_TRUE(step(0.25).success);
  EXPECT_TRUE(waitUntil([&] { return now() == paused_at + ros::Duration(0.25); }));
  EXPECT_FALSE(step(-1.0).success);
  EXPECT_FALSE(step(std::numeric_limits<double>::quiet_NaN()).success);
}

TEST_F(SimulatorNode, HearsCommandsWhileItSteps) {
  std_srvs::Trigger pause;
  ASSERT_TRUE(ros::service::call("simulator/pause", pause));
  const ros::Time begin = now();
  std::future<bool> stepped = std::async(std::launch::async, [this] { return step(300.0).success != 0; });
  ASSERT_TRUE(waitUntil([&] { return now() > begin + ros::Duration(1.0); })) << "no command before it steps";
  drive(0.3, 0.0, [&] { return stepped.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
  EXPECT_TRUE(stepped.get());
  EXPECT_TRUE(waitUntil([this] { return x_m() > 0.1; }));
}

TEST_F(SimulatorNode, ResetsTheRobotToAPose) {
  EXPECT_TRUE(placeAt(-3.0, 1.0, 0.5).success);
  EXPECT_TRUE(waitUntil([this] { return x_m() == -3.0; }));
  const ResetPose::Response refused = placeAt(0.0, std::numeric_limits<double>::infinity(), 0.0);
  EXPECT_FALSE(refused.success);
  EXPECT_THAT(refused.message, HasSubstr("not finite"));
}

TEST_F(SimulatorNode, ReportsATouchOnce) {
  Recorder<Contact> contacts(nh_, "ground_truth/contact");
  Recorder<std_msgs::UInt32> counts(nh_, "ground_truth/contacts");
  ASSERT_TRUE(contacts.waitForPublisher() && counts.waitForCount(1));
  const std::uint32_t before = counts.messages.back().data;
  placeAt(1.5, 0.0, 0.0);
  ASSERT_TRUE(drive(0.3, 0.0, [&] { return contacts.messages.size() == 1U; }));
  const ros::Time touched_at = now();
  drive(0.3, 0.0, [&] { return now() > touched_at + ros::Duration(2.0); });
  ASSERT_EQ(contacts.messages.size(), 1U);
  EXPECT_EQ(contacts.messages[0].other, "wall");
  EXPECT_EQ(contacts.messages[0].link, "body_link");
  EXPECT_TRUE(contacts.messages[0].driven_into);
  EXPECT_NEAR(contacts.messages[0].position.x, 2.0, 0.01);
  EXPECT_EQ(counts.messages.back().data, before + 1U);
  EXPECT_LT(x_m(), 2.0 - 0.12 + 1e-3);
}

TEST_F(SimulatorNode, AnotherSeedStartsTimeAnew) {
  ASSERT_TRUE(waitUntil([this] { return now() > ros::Time(2.0); }));
  SetSeed seed;
  seed.request.seed = 7;
  ASSERT_TRUE(ros::service::call("simulator/set_seed", seed));
  EXPECT_TRUE(seed.response.success);
  EXPECT_TRUE(waitUntil([this] { return now() < ros::Time(1.6); }));
}

TEST_F(SimulatorNode, KeepsItsWorldWhenAnotherIsMissing) {
  LoadWorld load;
  load.request.world = "package://frugal_nav/worlds/nowhere.world";
  ASSERT_TRUE(ros::service::call("simulator/load_world", load));
  EXPECT_FALSE(load.response.success);
  EXPECT_THAT(load.response.message, HasSubstr("nowhere.world"));
  const ros::Time before = now();
  EXPECT_TRUE(waitUntil([&] { return now() > before + ros::Duration(0.5); }));
  load.request.world = "package://frugal_nav/worlds/empty.world";
  ASSERT_TRUE(ros::service::call("simulator/load_world", load));
  EXPECT_TRUE(load.response.success) << load.response.message;
}

TEST(SimulatorProgram, AMissingWorldIsNamed) {
  const test::ProgramResult result =
      test::runProgram("simulator_node", "__name:=lost _world:=/nowhere/lost.world");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("/nowhere/lost.world"));
}

TEST(SimulatorProgram, NoWorldIsNamed) {
  const test::ProgramResult result = test::runProgram("simulator_node", "__name:=worldless");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("world is not set"));
}

TEST(SimulatorProgram, AMissingRobotIsNamed) {
  const test::ProgramResult result = test::runProgram(
      "simulator_node", "__name:=robotless _world:=any.world robot_description:=no_such_description");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("robot_description"));
}

TEST(SimulatorProgram, AnUnknownParameterIsNamed) {
  const test::ProgramResult result =
      test::runProgram("simulator_node", "__name:=misspelt _world:=any.world _lock_step:=true");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("lock_step"));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "simulator_node_test");
  const ros::NodeHandle keeps_ros_running;
  return RUN_ALL_TESTS();
}
