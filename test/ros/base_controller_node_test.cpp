#include "support/ros_test.hpp"

#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/TwistStamped.h>
#include <gmock/gmock.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <sensor_msgs/LaserScan.h>
#include <signal.h>
#include <sys/wait.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <unistd.h>
#include <visualization_msgs/MarkerArray.h>

#include <frugal_nav/LocalCommand.h>
#include <frugal_nav/MissionState.h>
#include <frugal_nav/Obstacle.h>

namespace frugal_nav {
namespace {

using test::runProgram;
using test::waitUntil;
using testing::HasSubstr;

constexpr double kCycle_s = 0.05;  // rate_hz 20
const double kNan = std::numeric_limits<double>::quiet_NaN();

/// The rest of the graph, faked: every topic the base controller hears, each of which can be switched off.
class Graph {
 public:
  explicit Graph(ros::NodeHandle& nh)
      : clock(nh),
        odom(nh.advertise<nav_msgs::Odometry>("odom", 50)),
        scan(nh.advertise<sensor_msgs::LaserScan>("scan", 50)),
        state(nh.advertise<MissionState>("mission/state", 50)),
        local(nh.advertise<LocalCommand>("avoidance/command", 50)),
        path(nh.advertise<nav_msgs::Path>("path", 50)),
        obstacle(nh.advertise<Obstacle>("obstacle/nearest", 50)),
        depth(nh.advertise<sensor_msgs::LaserScan>("depth/scan", 50)),
        mission(nh.advertise<geometry_msgs::TwistStamped>("mission/command", 50)),
        manual(nh.advertise<geometry_msgs::TwistStamped>("cmd_vel_in", 50)),
        cmd_vel(nh, "cmd_vel"),
        stamped(nh, "cmd_vel_stamped") {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "base_link";
    transform.child_frame_id = "laser";
    transform.transform.translation.x = 0.02;
    transform.transform.rotation.w = 1.0;
    transforms.sendTransform(transform);
    for (const ros::Publisher* publisher :
         {&odom, &scan, &state, &local, &path, &obstacle, &depth, &mission, &manual}) {
      connected = connected && test::waitForSubscriber(*publisher);
    }
    connected = connected && cmd_vel.waitForPublisher() && stamped.waitForPublisher() &&
                clock.waitForNode("robot/base_controller");
    local_msg.header.frame_id = path_msg.header.frame_id = "odom";
    local_msg.status = LocalCommand::STATUS_DRIVING;
    local_msg.holds = LocalCommand::HOLDS_VELOCITY;
    local_msg.v_mps = velocity.linear.x = 0.2;
    path_msg.poses.resize(2);
    path_msg.poses[0].pose.orientation.w = path_msg.poses[1].pose.orientation.w = 1.0;
    path_msg.poses[1].pose.position.x = 5.0;
    scan_msg.header.frame_id = "laser";
    scan_msg.angle_min = static_cast<float>(-M_PI);
    scan_msg.angle_increment = static_cast<float>(2.0 * M_PI / 360.0);
    scan_msg.angle_max = scan_msg.angle_min + 359 * scan_msg.angle_increment;
    scan_msg.range_min = 0.15F;
    scan_msg.range_max = 12.0F;
    scan_msg.ranges.assign(360, std::numeric_limits<float>::infinity());
    scan_msg.ranges[90] = 11.0F;  // a wall far to the right: a laser that sees nothing at all is no laser
    obstacle_msg.header.frame_id = "odom";
    depth_msg = scan_msg;
    depth_msg.header.frame_id = "base_link";
    depth_msg.angle_min = -0.5F;
    depth_msg.ranges.assign(58, std::numeric_limits<float>::infinity());
  }

  void sendOdom() { sendOdom(clock.now()); }
  void sendOdom(ros::Time stamp) {
    nav_msgs::Odometry msg;
    msg.header.stamp = stamp;
    msg.header.frame_id = "odom";
    msg.child_frame_id = "base_link";
    msg.pose.pose.orientation.w = 1.0;
    msg.twist.twist = odom_twist;
    odom.publish(msg);
  }
  void sendState() {
    state_msg.header.stamp = clock.now();
    state.publish(state_msg);
  }
  void sendScan() {
    scan_msg.header.stamp = clock.now();
    scan.publish(scan_msg);
  }
  void sendLocal() {
    local_msg.header.stamp = clock.now();
    local.publish(local_msg);
  }

  /// The next instant, one control cycle later: everything that is on, and the command that rests on it.
  void step() {
    const std::size_t before = stamped.messages.size();
    clock.advance(kCycle_s);
    geometry_msgs::TwistStamped twist;
    twist.header.stamp = path_msg.header.stamp = clock.now();
    twist.twist = velocity;
    if (scan_on) sendScan();
    if (odom_on) sendOdom();
    if (obstacle_on) {
      obstacle_msg.header.stamp = clock.now();
      obstacle.publish(obstacle_msg);
    }
    if (depth_on) {
      depth_msg.header.stamp = clock.now();
      depth.publish(depth_msg);
    }
    if (path_on) path.publish(path_msg);
    if (mission_on) mission.publish(twist);
    if (manual_on) manual.publish(twist);
    const bool in_turn = local_on && state_on && mission_on && odom_on && scan_on;
    if (local_on && !in_turn) sendLocal();
    if (state_on) sendState();
    const auto answered = [this](std::size_t already) {
      return stamped.messages.size() > already &&
             (!odom_on || stamped.messages.back().header.stamp >= clock.now());
    };
    // Without odometry only the timer starts cycles, before or after the scan of the same instant.
    ASSERT_TRUE(waitUntil([&] { return answered(before); }))
        << "no command rests on the sensors of this instant";
    if (!in_turn) return;
    // One after the other, so that no topic falls behind simulated time on a busy machine.
    const std::size_t after_state = stamped.messages.size();
    sendLocal();
    ASSERT_TRUE(waitUntil([&] { return answered(after_state); })) << "no command answers avoidance/command";
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) ASSERT_NO_FATAL_FAILURE(step());
  }
  /// Whether the last command is zero; before the first one the robot neither stands nor drives.
  bool standing() const {
    if (stamped.messages.empty()) return false;
    const geometry_msgs::Twist& twist = stamped.messages.back().twist;
    return twist.linear.x == 0.0 && twist.angular.z == 0.0;
  }
  bool driving() const { return !stamped.messages.empty() && !standing(); }
  /// Waits until the last command of an instant is zero.
  bool becomesZero() {
    return waitUntil([this] { return standing(); });
  }

  test::TestClock clock;
  tf2_ros::StaticTransformBroadcaster transforms;
  ros::Publisher odom, scan, state, local, path, obstacle, depth, mission, manual;
  test::Recorder<geometry_msgs::Twist> cmd_vel;
  test::Recorder<geometry_msgs::TwistStamped> stamped;
  bool connected = true;
  MissionState state_msg;
  LocalCommand local_msg;
  nav_msgs::Path path_msg;
  Obstacle obstacle_msg;  ///< there is none near
  sensor_msgs::LaserScan scan_msg;
  sensor_msgs::LaserScan depth_msg;
  geometry_msgs::Twist velocity;
  geometry_msgs::Twist odom_twist;
  bool odom_on = true, scan_on = true, state_on = true, local_on = true, path_on = true, mission_on = true,
       manual_on = true, obstacle_on = true, depth_on = true;
};

/// Time goes on from one test to the next; each begins with a driving robot in its mode.
class BaseControllerNodeTest : public testing::Test {
 protected:
  void SetUp() override {
    static ros::Time time(100.0);
    graph_ = std::make_unique<Graph>(nh_);
    ASSERT_TRUE(graph_->connected);
    graph_->clock.set(time + ros::Duration(3.0));
    time_ = &time;
  }
  void TearDown() override { *time_ = graph_->clock.now(); }

  void driveIn(std::uint8_t mode) {
    graph_->state_msg.mode = mode;
    graph_->state_msg.state = MissionState::STATE_DRIVING;
    ASSERT_NO_FATAL_FAILURE(graph_->steps(20));
    // On a busy machine one topic may lag behind the others by many of these steps, which take a millisecond
    // each.
    ASSERT_TRUE(waitUntil([this] { return graph_->driving(); })) << "it must drive before it can be stopped";
  }

  /// Whether it drives within two seconds more: topics may lag behind each other.
  bool drivesAgain() {
    for (int i = 0; i < 40 && !graph_->driving() && !testing::Test::HasFatalFailure(); ++i) graph_->step();
    return graph_->driving();
  }
  /// Whether it reaches a speed within two seconds more.
  bool drivesAt(double v_mps) {
    for (int i = 0; i < 40 && !testing::Test::HasFatalFailure(); ++i) {
      if (graph_->driving() && std::abs(graph_->stamped.messages.back().twist.linear.x - v_mps) < 1e-9)
        return true;
      graph_->step();
    }
    return false;
  }

  ros::NodeHandle nh_{"robot"};
  std::unique_ptr<Graph> graph_;
  ros::Time* time_ = nullptr;
};

TEST_F(BaseControllerNodeTest, EachModeFollowsItsSource) {
  graph_->local_msg.v_mps = 0.11;
  graph_->velocity.linear.x = 0.13;
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_LIDAR));
  EXPECT_TRUE(drivesAt(0.11));
  EXPECT_EQ(graph_->stamped.messages.back().header.frame_id, "base_link");
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_MANUAL));
  EXPECT_TRUE(drivesAt(0.13));
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_RECOVERING));
  EXPECT_TRUE(drivesAt(0.13));
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_CAMERA));
  EXPECT_TRUE(drivesAt(0.35));
  graph_->state_msg.mode = MissionState::MODE_IDLE;
  ASSERT_NO_FATAL_FAILURE(graph_->step());
  EXPECT_TRUE(graph_->becomesZero());
}

TEST_F(BaseControllerNodeTest, DrivesOnWhileSimulatedTimeLagsBehindTheStamps) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_LIDAR));
  const ros::Time ahead = graph_->clock.now() + ros::Duration(0.3);
  graph_->scan_msg.header.stamp = graph_->state_msg.header.stamp = graph_->local_msg.header.stamp = ahead;
  graph_->scan.publish(graph_->scan_msg);
  graph_->sendOdom(ahead);
  graph_->state.publish(graph_->state_msg);
  graph_->local.publish(graph_->local_msg);
  EXPECT_TRUE(waitUntil([&] { return graph_->stamped.messages.back().header.stamp >= ahead; }));
  EXPECT_TRUE(graph_->driving());
}

struct Stopped {
  const char* name;
  std::uint8_t mode;
  bool Graph::*input;
  double timeout_s;
};

class BaseControllerNodeWithout : public BaseControllerNodeTest,
                                  public testing::WithParamInterface<Stopped> {};

TEST_P(BaseControllerNodeWithout, CmdVelIsZeroWithinTheTimeOutAndOneCycle) {
  ASSERT_NO_FATAL_FAILURE(driveIn(GetParam().mode));
  (*graph_).*GetParam().input = false;
  const ros::Time last_input = graph_->clock.now();
  while (graph_->clock.now() < last_input + ros::Duration(GetParam().timeout_s + 0.5 * kCycle_s)) {
    ASSERT_NO_FATAL_FAILURE(graph_->step());
  }
  // The clock now stands at most one cycle beyond the time-out.
  EXPECT_TRUE(graph_->becomesZero()) << "still driving " << (graph_->clock.now() - last_input).toSec()
                                     << " s later";
  EXPECT_EQ(graph_->cmd_vel.messages.back().linear.x, 0.0);
  ASSERT_NO_FATAL_FAILURE(graph_->steps(5));
  EXPECT_TRUE(graph_->standing());
}
INSTANTIATE_TEST_SUITE_P(
    Inputs, BaseControllerNodeWithout,
    testing::Values(Stopped{"scan", MissionState::MODE_LIDAR, &Graph::scan_on, 0.5},
                    Stopped{"odom", MissionState::MODE_LIDAR, &Graph::odom_on, 0.25},
                    Stopped{"avoidance_command", MissionState::MODE_LIDAR, &Graph::local_on, 0.5},
                    Stopped{"mission_state", MissionState::MODE_LIDAR, &Graph::state_on, 0.25},
                    Stopped{"path", MissionState::MODE_CAMERA, &Graph::path_on, 1.0},
                    Stopped{"obstacle_nearest", MissionState::MODE_CAMERA, &Graph::obstacle_on, 1.0},
                    Stopped{"depth_scan", MissionState::MODE_CAMERA, &Graph::depth_on, 1.0},
                    Stopped{"mission_command", MissionState::MODE_ALIGNING, &Graph::mission_on, 0.25},
                    Stopped{"cmd_vel_in", MissionState::MODE_MANUAL, &Graph::manual_on, 0.25}),
    [](const auto& stopped) { return std::string(stopped.param.name); });

TEST_F(BaseControllerNodeTest, ANaNCommandStopsIt) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_LIDAR));
  graph_->local_msg.v_mps = kNan;
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));  // it may arrive after the cycle of its own instant
  EXPECT_TRUE(graph_->becomesZero());
  graph_->local_msg.v_mps = 0.2;
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_MANUAL));
  graph_->velocity.angular.z = kNan;
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));
  EXPECT_TRUE(graph_->becomesZero());
}

TEST_F(BaseControllerNodeTest, ACommandOutOfRangeStopsItAndIsCounted) {
  test::Recorder<diagnostic_msgs::DiagnosticArray> diagnostics(nh_, "/diagnostics");
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_MANUAL));
  graph_->velocity.linear.x = 80.0;
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));
  EXPECT_TRUE(graph_->becomesZero());
  const auto counted = [&] {
    graph_->clock.advance(0.5);
    for (const auto& array : diagnostics.messages) {
      for (const auto& status : array.status) {
        for (const auto& value : status.values) {
          if (value.key == "cmd_vel_in refused" && value.value != "0") return true;
        }
      }
    }
    return false;
  };
  EXPECT_TRUE(waitUntil(counted));
}

TEST_F(BaseControllerNodeTest, ATargetInAnotherFrameStopsIt) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_LIDAR));
  graph_->local_msg.holds = LocalCommand::HOLDS_TARGET;
  graph_->local_msg.target.position.x = 1.0;
  graph_->local_msg.target.orientation.w = 1.0;
  ASSERT_NO_FATAL_FAILURE(graph_->steps(3));
  EXPECT_TRUE(drivesAgain());
  graph_->local_msg.header.frame_id = "map";
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));
  EXPECT_TRUE(graph_->becomesZero());
}

TEST_F(BaseControllerNodeTest, AnImageOfNoUseStopsModeCamera) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_CAMERA));
  graph_->obstacle_msg.reason = "the image is black";
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));  // it may arrive after the cycle of its own instant
  EXPECT_TRUE(graph_->becomesZero());
}

TEST_F(BaseControllerNodeTest, AnObstacleOfTheCameraStopsIt) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_CAMERA));
  graph_->obstacle_msg.found = 1;
  graph_->obstacle_msg.sigma_m = 0.02;
  graph_->obstacle_msg.point.x = 0.17;  // 5 cm before the front, which stands at one place in odom
  graph_->odom_twist.linear.x = 0.5;
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));
  EXPECT_TRUE(graph_->becomesZero());
  graph_->obstacle_msg.point.x = 2.0;
  graph_->odom_twist.linear.x = 0.0;
  EXPECT_TRUE(drivesAgain());
  graph_->obstacle_msg.header.frame_id = "map";
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));
  EXPECT_TRUE(graph_->becomesZero());
}

TEST_F(BaseControllerNodeTest, WhatTheCameraSeesAheadStopsIt) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_CAMERA));
  for (std::size_t i = 20; i < 40; ++i) graph_->depth_msg.ranges[i] = 0.17F;
  graph_->odom_twist.linear.x = 0.5;
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));
  EXPECT_TRUE(graph_->becomesZero());
}

TEST_F(BaseControllerNodeTest, ATimeJumpStopsItUntilFreshInputsAreIn) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_LIDAR));
  graph_->scan_on = graph_->local_on = graph_->state_on = false;
  const std::size_t before = graph_->stamped.messages.size();
  graph_->clock.set(graph_->clock.now() - ros::Duration(60.0));
  graph_->sendOdom();
  // The clock stands: what comes now is of the new time, and only timer and odometry can have caused it.
  ASSERT_TRUE(waitUntil([&] {
    graph_->clock.advance(kCycle_s);
    return graph_->stamped.messages.size() > before && graph_->standing();
  }));
  graph_->odom_on = graph_->scan_on = graph_->state_on = true;
  ASSERT_NO_FATAL_FAILURE(graph_->steps(3));
  EXPECT_TRUE(graph_->standing()) << "no avoidance/command of the new time yet";
  graph_->local_on = true;
  ASSERT_NO_FATAL_FAILURE(graph_->steps(3));
  EXPECT_TRUE(drivesAgain());
}

TEST_F(BaseControllerNodeTest, AnObstacleAheadStopsIt) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_MANUAL));
  for (std::size_t i = 170; i < 190; ++i) graph_->scan_msg.ranges[i] = 0.16F;
  graph_->odom_twist.linear.x = 0.5;  // 6 cm from touching: at this speed there is no way to stop in time
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));
  EXPECT_TRUE(graph_->becomesZero());
}

TEST_F(BaseControllerNodeTest, ShowsWhatTheBarrierDoesToListeners) {
  test::Recorder<visualization_msgs::MarkerArray> markers(nh_, "base_controller/markers");
  ASSERT_TRUE(markers.waitForPublisher());
  const auto shows = [&](bool red) {
    return waitUntil([&] {
      if (markers.messages.empty()) return false;
      const visualization_msgs::Marker& outline = markers.messages.back().markers.front();
      return (outline.color.r > outline.color.g) == red;
    });
  };
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_MANUAL));
  ASSERT_TRUE(shows(false));
  const visualization_msgs::Marker& outline = markers.messages.back().markers.front();
  EXPECT_EQ(outline.header.frame_id, "base_link");
  ASSERT_EQ(outline.points.size(), 5U) << "a closed rectangle";
  EXPECT_EQ(outline.points[0], outline.points[4]);
  for (std::size_t i = 170; i < 190; ++i) graph_->scan_msg.ranges[i] = 0.16F;
  graph_->odom_twist.linear.x = 0.5;
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));
  ASSERT_TRUE(shows(true));
  EXPECT_THAT(markers.messages.back().markers[1].text, HasSubstr("collision stop"));
}

TEST_F(BaseControllerNodeTest, AScanInAnUnknownFrameStopsItAtOnce) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_LIDAR));
  graph_->scan_msg.header.frame_id = "nowhere";
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));  // not only by its time-out, 0.5 s later
  EXPECT_TRUE(graph_->becomesZero());
}

TEST_F(BaseControllerNodeTest, AScanWithHalfItsAngleIncrementStopsIt) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_LIDAR));
  graph_->scan_msg.angle_increment *= 0.5F;  // an obstacle straight ahead would seem to be on the right
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));
  EXPECT_TRUE(graph_->becomesZero());
  graph_->scan_msg.angle_increment *= 2.0F;
  EXPECT_TRUE(drivesAgain());
}

TEST_F(BaseControllerNodeTest, ALaserThatIsNotLevelStopsIt) {
  geometry_msgs::TransformStamped tilted;
  tilted.header.frame_id = "base_link";
  tilted.child_frame_id = "tilted";
  tilted.transform.rotation.x = std::sin(0.3);
  tilted.transform.rotation.w = std::cos(0.3);
  graph_->transforms.sendTransform(tilted);
  test::Recorder<diagnostic_msgs::DiagnosticArray> diagnostics(nh_, "/diagnostics");
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_LIDAR));
  graph_->scan_msg.header.frame_id = "tilted";
  ASSERT_NO_FATAL_FAILURE(graph_->steps(2));
  EXPECT_TRUE(graph_->becomesZero());
  const auto named = [&] {
    graph_->step();
    for (const auto& array : diagnostics.messages) {
      for (const auto& status : array.status) {
        for (const auto& value : status.values) {
          if (value.value.find("not mounted level") != std::string::npos) return true;
        }
      }
    }
    return false;
  };
  EXPECT_TRUE(waitUntil(named));
}

// What the simulator's lock-step relies on: at a standing clock each of the two triggers gives one command.
TEST_F(BaseControllerNodeTest, OneCommandForEachTrigger) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_LIDAR));
  graph_->clock.advance(0.01);  // less than the timer's period
  const auto commandsAfter = [this](const std::function<void()>& trigger, std::size_t expected) {
    const std::size_t before = graph_->stamped.messages.size();
    trigger();
    waitUntil([&] { return graph_->stamped.messages.size() >= before + expected; });
    return graph_->stamped.messages.size() - before;
  };
  EXPECT_EQ(commandsAfter(
                [this] {
                  graph_->sendOdom();
                  graph_->sendState();
                },
                1),
            1U);
  EXPECT_EQ(graph_->stamped.messages.back().header.stamp, graph_->clock.now());
  EXPECT_EQ(commandsAfter(
                [this] {
                  graph_->sendScan();
                  graph_->sendLocal();
                },
                1),
            1U);
  EXPECT_EQ(graph_->cmd_vel.messages.size(), graph_->stamped.messages.size());
}

// The simulator's lock-step waits for a command to each image, also while the mission turns the robot.
TEST_F(BaseControllerNodeTest, OneCommandForEachImageWhileRecovering) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_RECOVERING));
  graph_->clock.advance(0.01);
  const std::size_t before = graph_->stamped.messages.size();
  graph_->sendOdom();
  graph_->obstacle_msg.header.stamp = graph_->path_msg.header.stamp = graph_->clock.now();
  graph_->obstacle.publish(graph_->obstacle_msg);
  graph_->depth_msg.header.stamp = graph_->clock.now();
  graph_->depth.publish(graph_->depth_msg);
  graph_->path.publish(graph_->path_msg);
  ASSERT_TRUE(graph_->stamped.waitForCount(before + 1));
  EXPECT_EQ(graph_->stamped.messages.back().header.stamp, graph_->clock.now());
}

TEST_F(BaseControllerNodeTest, ACycleWaitsForTheOdometryItRestsOn) {
  ASSERT_NO_FATAL_FAILURE(driveIn(MissionState::MODE_LIDAR));
  graph_->clock.advance(0.01);
  const std::size_t before = graph_->stamped.messages.size();
  graph_->sendState();  // overtakes its odometry
  EXPECT_FALSE(graph_->stamped.waitForCount(before + 1, 0.3)) << "a command on the odometry before";
  graph_->sendOdom();
  ASSERT_TRUE(graph_->stamped.waitForCount(before + 1));
  EXPECT_EQ(graph_->stamped.messages.back().header.stamp, graph_->clock.now());
}

using Arguments = std::vector<const char*>;

const Arguments kNodelet{"rosrun", "nodelet", "nodelet", "standalone", "frugal_nav/base_controller"};

/// Starts a second controller, waits until it commands, ends it, and expects its last word to be zero.
void expectZeroAtExit(const std::function<void(pid_t)>& end, Arguments arguments = {}) {
  ros::NodeHandle nh("robot/leaving");
  test::Recorder<geometry_msgs::Twist> cmd_vel(nh, "cmd_vel");
  const std::string program = test::programPath("base_controller_node");
  if (arguments.empty()) arguments = {program.c_str()};
  arguments.insert(arguments.end(), {"__ns:=robot/leaving", "__name:=leaving", nullptr});
  const pid_t child = fork();
  if (child == 0) {
    execvp(arguments[0], const_cast<char* const*>(arguments.data()));
    _exit(127);
  }
  ASSERT_TRUE(cmd_vel.waitForPublisher());
  // Its timer needs time to run, and it is silent until then: with the clock standing only its farewell can
  // come.
  const std::size_t before = cmd_vel.messages.size();
  end(child);
  EXPECT_TRUE(cmd_vel.waitForCount(before + 1));
  int status = 0;
  ASSERT_TRUE(waitUntil([&] { return waitpid(child, &status, WNOHANG) == child; }));
  EXPECT_TRUE(WIFEXITED(status));
  ASSERT_FALSE(cmd_vel.messages.empty());
  EXPECT_EQ(cmd_vel.messages.back().linear.x, 0.0);
}

TEST(BaseControllerNode, PublishesZeroWhenInterrupted) {
  expectZeroAtExit([](pid_t child) { kill(child, SIGINT); });
}

TEST(BaseControllerNode, PublishesZeroWhenTerminated) {
  expectZeroAtExit([](pid_t child) { kill(child, SIGTERM); });
}

TEST(BaseControllerNode, PublishesZeroWhenKilledThroughRos) {
  expectZeroAtExit(
      [](pid_t) { EXPECT_EQ(std::system("rosnode kill /robot/leaving/leaving > /dev/null"), 0); });
}

TEST(BaseControllerNodelet, PublishesZeroWhenItsManagerIsInterrupted) {
  expectZeroAtExit([](pid_t child) { kill(child, SIGINT); }, kNodelet);
}

TEST(BaseControllerNodelet, PublishesZeroWhenItsManagerIsTerminated) {
  expectZeroAtExit([](pid_t child) { kill(child, SIGTERM); }, kNodelet);
}

TEST(BaseControllerNodelet, PublishesZeroWhenItsManagerIsKilledThroughRos) {
  expectZeroAtExit(
      [](pid_t) { EXPECT_EQ(std::system("rosnode kill /robot/leaving/leaving > /dev/null"), 0); }, kNodelet);
}

TEST(BaseControllerNode, AMissingRobotDescriptionIsNamed) {
  const test::ProgramResult result = runProgram("base_controller_node", "__ns:=nowhere");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("robot_description"));
}

TEST(BaseControllerNode, AnUnknownParameterIsNamed) {
  const test::ProgramResult result =
      runProgram("base_controller_node", "__ns:=robot __name:=unknown_key _limits/max_speed_mps:=1.0");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("limits/max_speed_mps"));
}

TEST(BaseControllerNode, AParameterOutOfItsRangeIsNamed) {
  const test::ProgramResult result =
      runProgram("base_controller_node", "__ns:=robot __name:=bad_range _timeouts/odom_s:=-1.0");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("timeouts/odom_s"));
}

TEST(BaseControllerNode, AParameterOfAWrongTypeIsNamed) {
  const test::ProgramResult result =
      runProgram("base_controller_node", "__ns:=robot __name:=wrong_type _require_scan:=often");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("require_scan"));
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  ros::init(argc, argv, "base_controller_node_test");
  const ros::NodeHandle keeps_ros_running;
  return RUN_ALL_TESTS();
}
