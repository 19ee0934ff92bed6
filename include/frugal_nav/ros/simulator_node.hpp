#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <geometry_msgs/Twist.h>
#include <geometry_msgs/TwistStamped.h>
#include <image_transport/image_transport.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <frugal_nav/LoadWorld.h>
#include <frugal_nav/ResetPose.h>
#include <frugal_nav/SetSeed.h>
#include <frugal_nav/StepSimulation.h>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/simulator_pacer.hpp>
#include <frugal_nav/sim/simulator.hpp>

namespace frugal_nav {

/// Parameters of the simulator's node; those of the simulator itself stand beside them.
struct SimulatorNodeParams {
  std::string world;
  double start_x_m = 0.0;
  double start_y_m = 0.0;
  double start_yaw_rad = 0.0;
  int seed = 1;
  double real_time_factor = 1.0;
  bool paused = false;
  bool lockstep = false;
  std::vector<std::string> lockstep_sensors{"wheel_ticks", "scan"};
  double lockstep_wait_s = 2.0;
  double lockstep_start_wait_s = 30.0;
  bool publish_world_tf = false;
  std::string map_frame;
  sim::SimulatorParams simulator = withCamera();

  template <class Visitor>
  void fields(Visitor&& visit) {
    const double infinity = std::numeric_limits<double>::infinity();
    visit("world", world,
          Field{"", "the world file: a path, or a URI as package://frugal_nav/worlds/lab.world"});
    visit("start_x_m", start_x_m, Field{"m", "where the robot starts, in the world"});
    visit("start_y_m", start_y_m, Field{"m", "where the robot starts, in the world"});
    visit("start_yaw_rad", start_yaw_rad, Field{"rad", "which way the robot looks at the start"});
    visit("seed", seed,
          Field{"", "of all noise: the same seed and commands give the same bytes", 0, infinity});
    visit("real_time_factor", real_time_factor,
          Field{"", "simulated over wall time at most; 0 is as fast as possible", 0.0, 1000.0});
    visit("paused", paused, Field{"", "start paused; ~resume and ~step go on"});
    visit("lockstep", lockstep,
          Field{"",
                "wait for the command to each sensor message (cmd_vel_stamped), so that a slow machine gives "
                "the same run as a fast one"});
    visit("lockstep_sensors", lockstep_sensors,
          Field{"", "the sensors whose command is waited for, of wheel_ticks, scan and camera"});
    visit(
        "lockstep_wait_s", lockstep_wait_s,
        Field{"s", "longest wait for a command, in wall time; then it is missed, and counted", 0.01, 600.0});
    visit("lockstep_start_wait_s", lockstep_start_wait_s,
          Field{"s", "longest wait for the graph to connect before the clock starts, in wall time", 0.0,
                600.0});
    visit("publish_world_tf", publish_world_tf,
          Field{"", "publish world -> odom at the start pose, for rviz: the truth is otherwise kept apart"});
    visit(
        "map_frame", map_frame,
        Field{"",
              "publish world -> this frame, which is the same: that of a map of the world; empty for none"});
    simulator.fields(visit);
  }
  std::string check() const;
  /// Whether the command to a sensor's message is waited for.
  bool waitsFor(const std::string& sensor) const;
  /// Images a second: of the RGB-D camera where it stands in for the colour one.
  double imageRate_hz() const;

 private:
  static sim::SimulatorParams withCamera();
};

/// The simulator as a node: publishes sensors, clock and truth, takes commands. Everything runs in the thread
/// that calls run(): what happens between two steps does so in one order.
class SimulatorNode {
 public:
  /// Throws ConfigError on bad parameters, a missing world or a missing robot.
  SimulatorNode(const ros::NodeHandle& nh, const ros::NodeHandle& pnh);

  /// Simulates until the node is shut down.
  void run();

 private:
  void advertise();
  void subscribe();
  /// Builds the world anew; throws ConfigError and leaves all as it was when it cannot.
  void build(const std::string& world, std::uint64_t seed);

  void publishWorldTf(const std::string& frame, const Pose2& world_from_frame);

  bool graphIsConnected();
  void advance();
  void stepOnce();
  void publish(const sim::SimOutput& output);
  void publishClock();
  void publishImages(const sim::SimOutput& output);
  void publishContacts(const sim::SimOutput& output);
  /// Publishes a sensor's message and, in lock-step, waits for the command to it.
  void publishAndWait(const std::string& sensor, Stamp stamp, const std::function<void()>& send);
  void switchSensors();
  void takeCommand(const geometry_msgs::Twist& twist, Stamp stamp);
  void takeStampedCommand(const geometry_msgs::TwistStamped& msg);
  void report();

  bool pause(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  bool resume(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  bool step(StepSimulation::Request& request, StepSimulation::Response& response);
  bool resetPose(ResetPose::Request& request, ResetPose::Response& response);
  bool loadWorld(LoadWorld::Request& request, LoadWorld::Response& response);
  bool setSeed(SetSeed::Request& request, SetSeed::Response& response);

  ros::NodeHandle nh_;
  ros::NodeHandle pnh_;
  SimulatorNodeParams params_;
  RobotModel robot_;
  std::string world_;
  std::uint64_t seed_ = 0;
  std::unique_ptr<sim::Simulator> simulator_;
  SimulatorPacer pacer_;
  NodeDiagnostics diagnostics_;
  ros::WallTime start_;
  bool paused_ = false;
  bool is_connected_ = false;

  ros::CallbackQueue command_queue_;  ///< of cmd_vel_stamped: served only while a command is waited for
  std::optional<geometry_msgs::TwistStamped> last_command_;
  Stamp awaited_{};
  bool is_answered_ = false;
  std::uint64_t missed_waits_ = 0;

  image_transport::ImageTransport images_;
  image_transport::CameraPublisher image_publisher_;
  image_transport::CameraPublisher depth_publisher_;
  ros::Publisher clock_publisher_;
  ros::Publisher ticks_publisher_;
  ros::Publisher imu_publisher_;
  ros::Publisher scan_publisher_;
  ros::Publisher truth_publisher_;
  ros::Publisher contact_publisher_;
  ros::Publisher contact_count_publisher_;
  ros::Subscriber command_subscriber_;
  std::vector<ros::ServiceServer> services_;
  tf2_ros::StaticTransformBroadcaster world_tf_;
};

}  // namespace frugal_nav
