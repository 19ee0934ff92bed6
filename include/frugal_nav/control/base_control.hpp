#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/mission_status.hpp>
#include <frugal_nav/common/motion_command.hpp>
#include <frugal_nav/common/nearest_obstacle.hpp>
#include <frugal_nav/common/odometry_buffer.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/control/blind_watch.hpp>
#include <frugal_nav/control/collision_guard.hpp>
#include <frugal_nav/control/path_follower.hpp>
#include <frugal_nav/control/scan_memory.hpp>
#include <frugal_nav/control/velocity_limiter.hpp>
#include <frugal_nav/control/watchdog.hpp>
#include <frugal_nav/control/waypoint_controller.hpp>

namespace frugal_nav {

/// How old each input may be.
struct BaseTimeouts {
  double odom_s = 0.25;
  double mission_state_s = 0.25;
  double mission_command_s = 0.25;
  double cmd_vel_in_s = 0.25;
  double scan_s = 0.5;
  double avoidance_command_s = 0.5;
  double path_s = 1.0;
  double obstacle_s = 1.0;
  double depth_scan_s = 1.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("odom_s", odom_s,
          Field{"s", "age of odom that stops the robot: a dozen readings missed", 0.02, 10.0});
    visit("mission_state_s", mission_state_s,
          Field{"s", "of mission/state, which comes with each odom", 0.02, 10.0});
    visit("mission_command_s", mission_command_s, Field{"s", "of mission/command", 0.02, 10.0});
    visit("cmd_vel_in_s", cmd_vel_in_s, Field{"s", "of cmd_vel_in", 0.02, 10.0});
    visit("scan_s", scan_s,
          Field{"s", "of scan: an RPLIDAR turns at 5.5 Hz, so one missed turn passes", 0.05, 10.0});
    visit("avoidance_command_s", avoidance_command_s,
          Field{"s", "of avoidance/command, which has the stamp of its scan", 0.05, 10.0});
    visit("path_s", path_s,
          Field{"s", "of path in mode camera: 2.5 periods of the camera pipeline", 0.05, 10.0});
    visit("obstacle_s", obstacle_s, Field{"s", "of obstacle/nearest in mode camera, likewise", 0.05, 10.0});
    visit("depth_scan_s", depth_scan_s,
          Field{"s", "of depth/scan in mode camera, likewise, once one has come", 0.05, 10.0});
  }
};

/// Commands, and speeds of odometry, beyond this are errors: they are refused, not clamped.
struct PlausibleCommands {
  double max_v_mps = 5.0;
  double max_w_radps = 15.0;
  double max_target_distance_m = 100.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("max_v_mps", max_v_mps, Field{"m/s", "a faster command is refused", 0.1, 100.0});
    visit("max_w_radps", max_w_radps, Field{"rad/s", "a faster turn is refused", 0.1, 100.0});
    visit("max_target_distance_m", max_target_distance_m,
          Field{"m", "a target or path farther from the robot is refused", 1.0, 1e6});
  }
};

/// All that the base's commands are made with.
struct BaseControlParams {
  bool require_scan = true;
  bool require_scan_in_manual = true;
  double blind_mps = 0.10;
  double future_tolerance_s = 0.05;
  ScanRules scan;
  BaseTimeouts timeouts;
  PlausibleCommands plausible;
  VelocityLimits limits;
  CollisionGuardParams guard;
  ScanMemoryParams depth;
  ScanMemoryParams near = ScanMemoryParams::ofLaser();
  WaypointParams waypoint;
  PathFollowerParams path;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("require_scan", require_scan,
          Field{"",
                "no motion without a scan while following a path, aligning or recovering; mode lidar always "
                "needs one. Once a scan has come, every mode needs fresh ones"});
    visit("require_scan_in_manual", require_scan_in_manual,
          Field{"",
                "no motion by cmd_vel_in without a scan; false: a base without a scanner may be steered by "
                "hand"});
    visit("blind_mps", blind_mps,
          Field{"m/s", "fastest into a direction the last three scans saw nothing of, neither free nor hit",
                0.0, 5.0});
    visit("future_tolerance_s", future_tolerance_s,
          Field{"s",
                "an input stamped later than this after now is a fault: clocks differ. It lengthens every "
                "time-out: by one cycle. In simulated time, whose messages lag, it is 1 s at least",
                0.0, 10.0});
    visit("scan", scan);
    visit("timeouts", timeouts);
    visit("plausible", plausible);
    visit("limits", limits);
    visit("guard", guard);
    visit("depth", depth);
    visit("near", near);
    visit("waypoint", waypoint);
    visit("path", path);
  }
};

/// The base's size, from the URDF.
struct BaseGeometry {
  Polygon2 footprint;  ///< convex, counter-clockwise, in base_link
  double wheel_separation_m = 0.0;
};

/// What the base is to do now, and why it stands when it does.
struct BaseCommand {
  enum class Source { kNone, kAvoidance, kPath, kMission, kManual };
  enum class Reason {
    kNone,      ///< it moves, or its source asks for zero
    kIdle,      ///< no goal
    kNoWay,     ///< the source has nothing to drive to; `text` is its reason
    kMissing,   ///< an input has not come yet, or not since time jumped back
    kStale,     ///< an input is older than its time-out
    kRefused,   ///< an input was not finite, out of range or unusable
    kObstacle,  ///< the collision stop
  };

  Twist2 velocity;
  Stamp stamp{};  ///< of the newest sensor message it rests on
  Source source = Source::kNone;
  Reason reason = Reason::kNone;
  std::string text;          ///< says the reason in words
  double guard_share = 1.0;  ///< what the collision stop left of the speed
};

/// Decides the base's velocity: the mode's source, over it limits, time-outs and collision stop. Any doubt
/// gives zero at once, without a ramp.
///
/// Inputs may come in any order, each with stamps that do not go back; one that does is a jump of time, which
/// forgets everything. An input that is refused stops the base until a sound one of its kind comes.
class BaseControl {
 public:
  /// Throws ConfigError on parameters out of range or an impossible geometry.
  BaseControl(const BaseControlParams& params, const BaseGeometry& geometry);

  // Each gives false when it refuses the input; refusal() then says why.
  bool setMission(const MissionStatus& status);
  bool setOdometry(const Odometry& odometry);
  bool setScan(const LaserScan& as_sent, const Pose2& base_from_laser);
  bool setLocalCommand(const MotionCommand& command);
  /// A path in odom, for mode camera; stamped with the image it rests on.
  bool setPath(const Path2& path, Stamp stamp);
  /// The nearest obstacle in the camera's view, for mode camera. One that was not found for a reason is a
  /// fault: the image was of no use.
  bool setObstacle(const NearestObstacle& obstacle);
  /// What the camera sees, as a scan in base_link; beams without knowledge are NaN, all of them if need be.
  bool setDepthScan(const LaserScan& scan);
  bool setMissionCommand(const Twist2& velocity, Stamp stamp);
  bool setManualCommand(const Twist2& velocity, Stamp stamp);
  /// An input that could not even be converted; `input` is its topic.
  void refuse(const std::string& input, const std::string& why);
  /// Why an input's last value was refused; empty when it was not.
  std::string refusal(const std::string& input) const;

  /// One control cycle. Time running backward forgets everything.
  BaseCommand cycle(Stamp now);

  /// Forgets all inputs; zero until fresh ones are in.
  void reset();
  /// Other parameters from the next cycle on. Throws ConfigError on parameters out of range.
  void setParams(const BaseControlParams& params);
  /// Mode of the last mission state; kIdle before.
  Mode mode() const { return mission_.mode; }
  /// The base's outline in base_link.
  const Polygon2& footprint() const { return geometry_.footprint; }
  /// How often time jumped back.
  std::uint64_t timeJumps() const { return time_jumps_; }

 private:
  bool accept(const std::string& input, Stamp stamp, const std::optional<std::string>& fault);
  Stamp newestStamp(Stamp now) const;
  Stamp sensorStamp() const;
  BaseCommand decide(Stamp now);
  std::optional<BaseCommand> faultOf(const std::string& input, Stamp now) const;
  std::vector<std::string> requiredInputs() const;
  BaseCommand wanted(Stamp now, const Pose2& odom_from_base);
  BaseCommand localCommand(const Pose2& odom_from_base) const;
  BaseCommand pathCommand(Stamp now, const Pose2& odom_from_base);
  BaseCommand restrict(const BaseCommand& command, Stamp now, const Odometry& odometry);
  std::optional<std::vector<Eigen::Vector2d>> obstaclesAt(Stamp now, const Pose2& odom_from_base) const;
  void addNearest(Stamp now, const Pose2& odom_from_base, std::vector<Eigen::Vector2d>& p_base) const;
  Eigen::Vector2d nearestOn(const LaserScan& scan, std::size_t beam, const Pose2& base_from_laser) const;
  LaserScan withoutOwnParts(LaserScan scan, const Pose2& base_from_laser) const;
  bool isBlind(double v_mps) const;

  BaseControlParams params_;
  BaseGeometry geometry_;
  WaypointController waypoint_;
  PathFollower follower_;
  VelocityLimiter limiter_;
  CollisionGuard guard_;
  Watchdog watchdog_;
  BlindWatch blind_;

  OdometryBuffer odometry_;
  MissionStatus mission_;
  Stamp goal_since_{};  // commands older than the goal are for the one before
  MotionCommand local_command_;
  Path2 path_;
  Twist2 mission_command_;
  Twist2 manual_command_;
  Stamp scan_stamp_{};
  std::vector<Eigen::Vector2d> p_base_at_scan_;
  bool has_scanner_ = false;
  NearestObstacle obstacle_;
  ScanMemory depth_;
  ScanMemory near_;  // of scan: what is too near to measure, or out of its view
  bool has_depth_ = false;

  std::optional<Stamp> last_now_;
  bool time_jumped_ = false;
  Twist2 issued_;  // at issued_at_: what accelerations are limited from is the command of the instant before
  Twist2 before_;
  std::optional<Stamp> issued_at_;
  std::optional<Stamp> before_at_;
  std::map<std::string, std::string> refused_;
  std::uint64_t time_jumps_ = 0;
};

}  // namespace frugal_nav
