#pragma once

#include <string>

#include <frugal_nav/mission/mission.hpp>

namespace frugal_nav {

/// A mission that follows whom the camera sees.
inline MissionParams cameraParams() {
  MissionParams params;
  params.drive_mode = "camera";
  params.follow_observed = true;
  return params;
}

/// Feeds a mission with odometry at 20 Hz, and with a path and a local command at each of them: what a
/// healthy graph gives. Tests change what it feeds.
class MissionDriver {
 public:
  explicit MissionDriver(const MissionParams& params = {}) : mission(params) {
    command.status = MotionCommand::Status::kDriving;
    command.holds = MotionCommand::Holds::kTarget;
  }

  /// One instant: the inputs, then the odometry.
  MissionOutput step(double dt_s = 0.05) {
    time_s += dt_s;
    odometry.stamp = stampFromSeconds(time_s);
    command.stamp = odometry.stamp;
    if (feed_command) mission.setLocalCommand(command);
    if (feed_path) mission.setPath(path(), odometry.stamp, path_reason);
    return mission.update(odometry);
  }

  /// Steps for a while; the output of the last instant.
  MissionOutput run(double duration_s) {
    MissionOutput output;
    for (double end_s = time_s + duration_s; time_s < end_s - 1e-9;) output = step();
    return output;
  }

  /// Steps until the phase is no longer `phase`, at most for `limit_s`; the output of the last instant.
  MissionOutput runWhile(MissionPhase phase, double limit_s) {
    MissionOutput output = step();
    for (const double end_s = time_s + limit_s; output.status.phase == phase && time_s < end_s;)
      output = step();
    return output;
  }

  /// Steps with a robot that obeys what the mission commands and nothing else.
  MissionOutput stepObeying(double dt_s = 0.05) {
    const MissionOutput output = step(dt_s);
    odometry.twist = output.command.value_or(Twist2{});
    odometry.odom_from_base = odometry.odom_from_base * arcMotion(odometry.twist, dt_s);
    return output;
  }

  std::uint32_t setGoal(const Pose2& goal, bool with_yaw = true) {
    return mission.setGoal(goal, stampFromSeconds(time_s), with_yaw);
  }

  Path2 path() const {
    if (!path_found) return {};
    const Pose2 begin = odometry.odom_from_base;
    const Pose2 end = mission.goal();
    const Eigen::Vector2d middle = 0.5 * (begin.position() + end.position());
    return {begin, {middle.x(), middle.y() + path_bend_m, 0.0}, end};
  }

  Mission mission;
  double time_s = 100.0;
  Odometry odometry;
  MotionCommand command;
  bool feed_command = true;
  bool feed_path = true;
  bool path_found = true;
  double path_bend_m = 0.0;  ///< its middle lies this far beside the straight line
  std::string path_reason;
};

}  // namespace frugal_nav
