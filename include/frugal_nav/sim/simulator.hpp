#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/robot/robot_model.hpp>
#include <frugal_nav/sim/camera.hpp>
#include <frugal_nav/sim/drive_body.hpp>
#include <frugal_nav/sim/imu.hpp>
#include <frugal_nav/sim/lidar.hpp>
#include <frugal_nav/sim/lighting.hpp>
#include <frugal_nav/sim/ray_tracer.hpp>
#include <frugal_nav/sim/rgbd_camera.hpp>
#include <frugal_nav/sim/scene.hpp>
#include <frugal_nav/sim/sensor_data.hpp>
#include <frugal_nav/sim/wheel_encoders.hpp>

namespace frugal_nav::sim {

/// Which sensors give data. Each draws from its own random stream: switching one leaves the others' bytes.
struct SensorSwitches {
  bool wheel_ticks = true;
  bool imu = true;
  bool scan = true;
  bool camera = false;
  bool rgbd = false;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("wheel_ticks", wheel_ticks, Field{"", "wheel encoders"});
    visit("imu", imu, Field{"", "inertial measurement unit, at imu_link"});
    visit("scan", scan, Field{"", "laser scanner, at laser"});
    visit("camera", camera, Field{"", "colour camera, at camera_optical_frame"});
    visit("rgbd", rgbd, Field{"", "colour-and-depth camera, at camera_optical_frame"});
  }
};

/// All of a simulator's parameters.
struct SimulatorParams {
  double command_timeout_s = 0.5;
  SensorSwitches sensors;
  DriveBodyParams body;
  WheelEncoderParams encoders;
  ImuParams imu;
  LidarParams lidar;
  CameraParams camera;
  RgbdParams rgbd;
  LightingParams lighting;
  RayTracerParams ray_tracer;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("command_timeout_s", command_timeout_s,
          Field{"s", "a command older than this stops the wheels, as a base driver does", 0.02, 1e9});
    visit("sensors", sensors);
    visit("body", body);
    visit("encoders", encoders);
    visit("imu", imu);
    visit("lidar", lidar);
    visit("camera", camera);
    visit("rgbd", rgbd);
    visit("lighting", lighting);
    visit("ray_tracer", ray_tracer);
  }
};

/// What one step gave: the sensors that were due, and the touches that began.
struct SimOutput {
  Stamp stamp{};
  std::optional<WheelTicks> ticks;
  std::optional<ImuSample> imu;
  std::optional<LaserScan> scan;
  std::optional<CameraImage> image;
  std::optional<RgbdImages> rgbd;
  std::vector<Contact> contacts;
};

/// The physics step.
constexpr Duration kPhysicsStep = std::chrono::milliseconds(5);
/// The time a simulation starts at: ROS takes zero for "no time".
constexpr Stamp kStartTime = stampFromSeconds(1.0);

/// A robot in a world: body, contact, sensors and people, advanced step by step. The same arguments and calls
/// give the same bytes. Sensor periods are rounded to whole physics steps, the scanner's to whole encoder
/// periods, so that both fall together. The robot's own body is invisible to its sensors.
class Simulator {
 public:
  /// Throws ConfigError on parameters out of range, a link the URDF lacks, a scene that cannot be built, or a
  /// start pose that is not finite. People of the scene are added to it; their time is that since kStartTime.
  Simulator(Scene scene, RobotModel robot, const SimulatorParams& params, std::uint64_t seed,
            const Pose2& world_from_start);
  ~Simulator();
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;

  /// What the wheels are to do, until the next command or the time-out. A command that is not finite is
  /// refused (false) and stops them.
  bool setCommand(const Twist2& command);
  /// Advances by kPhysicsStep.
  SimOutput step();

  Stamp stamp() const;
  GroundTruth groundTruth() const;
  /// Touches begun since the start.
  int contactCount() const;
  /// Puts the robot at a pose, standing still; time, counts and sensors go on.
  void reset(const Pose2& world_from_base);
  /// Switches sensors while running, of those that were on at the start.
  void setSensors(const SensorSwitches& sensors);
  /// Moves a model of the scene (an obstacle on a course of its own) for the next step. Throws ConfigError on
  /// a model that does not exist.
  void moveModel(int model, const Eigen::Isometry3d& world_from_model);
  /// Lets a person of the scene set out now, whatever its start_delay_s said. Throws ConfigError on a person
  /// that does not exist.
  void startPerson(int person);

  /// The time between two scans, as rounded.
  Duration scanPeriod() const;
  const Scene& scene() const;
  const RobotModel& robot() const;
  const SimulatorParams& params() const;
  /// The lens of the colour camera (of the RGB-D one when only that is on).
  const Camera& camera() const;
  /// The tracer of the scene as it was when a sensor last used it.
  const RayTracer& tracer() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace frugal_nav::sim
