#include "node_params.hpp"

#include <filesystem>
#include <optional>
#include <vector>

#include <frugal_nav/eval/lidar_stack.hpp>

namespace frugal_nav::eval {
namespace {

BodyExtent extentOf(const RobotModel& robot) { return {robot.halfWidth_m(), robot.circumradius_m()}; }

}  // namespace

LidarStackParams loadLidarStack(const std::string& config_dir, const std::string& profile) {
  const auto files = [&](const std::string& name) {
    std::vector<std::string> paths{config_dir + "/" + name};
    const std::string own = config_dir + "/" + profile + "/" + name;
    if (std::filesystem::exists(own)) paths.push_back(own);
    return paths;
  };
  LidarStackParams params;
  params.odometry = loadPart<WheelOdometryParams>(files("wheel_odometry.yaml"));
  params.planner = loadPart<LidarPlannerParams>(files("planner.yaml"));
  params.avoidance = loadPart<LidarAvoidanceParams>(files("lidar_avoidance.yaml"));
  params.mission = loadPart<MissionParams>(files("mission.yaml"));
  params.base = loadPart<BaseControlParams>(files("base_controller.yaml"));
  return params;
}

LidarStack::LidarStack(const LidarStackParams& params, const RobotModel& robot)
    : uses_path_(params.avoidance.use_path),
      base_from_laser_(robot.planarBaseFrom("laser")),
      wheels_(params.odometry, {robot.drive.radius_m, robot.drive.separation_m}),
      mission_(params.mission),
      planner_(params.planner, extentOf(robot)),
      avoidance_(params.avoidance, extentOf(robot)),
      base_(params.base, {robot.footprint, robot.drive.separation_m}) {}

void LidarStack::setGoal(const Pose2& odom_from_goal, Stamp stamp) {
  mission_.setGoal(odom_from_goal, stamp, false);
}

void LidarStack::passGoal() {
  const MissionPhase phase = mission_.status().phase;
  const bool active = phase == MissionPhase::kDriving || phase == MissionPhase::kRecovering;
  const std::optional<Pose2> goal = active ? std::optional<Pose2>(mission_.goal()) : std::nullopt;
  planner_.setGoal(goal);
  avoidance_.setGoal(goal);
}

BaseCommand LidarStack::addTicks(Stamp stamp, std::int64_t left, std::int64_t right) {
  if (const auto odometry = wheels_.addTicks(stamp, left, right)) {
    odometry_ = *odometry;
    buffer_.add(odometry_);
    base_.setOdometry(odometry_);
    const MissionOutput output = mission_.update(odometry_);
    base_.setMission(output.status);
    if (output.command) base_.setMissionCommand(*output.command, output.status.stamp);
  }
  return base_.cycle(stamp);
}

BaseCommand LidarStack::addScan(const LaserScan& scan) {
  base_.setScan(scan, base_from_laser_);
  if (const auto odometry = buffer_.at(scan.stamp)) {
    passGoal();
    if (uses_path_) {
      plan_ = planner_.update(scan, base_from_laser_, odometry->odom_from_base);
      mission_.setPath(plan_.path, plan_.stamp, plan_.reason);
      avoidance_.setPath(plan_.stamp, plan_.path);
    }
    local_ = avoidance_.update(scan, base_from_laser_, *odometry);
    local_.goal_number = mission_.status().goal_number;
    mission_.setLocalCommand(local_);
    base_.setLocalCommand(local_);
  }
  return base_.cycle(scan.stamp);
}

}  // namespace frugal_nav::eval
