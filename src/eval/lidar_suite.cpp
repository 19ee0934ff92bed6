#include "lidar_suite.hpp"

#include "lidar_drive.hpp"
#include "straight_drive.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/eval/lidar_stack.hpp>
#include <frugal_nav/eval/random_world.hpp>
#include <frugal_nav/eval/statistics.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav::eval {
namespace {

// A success ends this near to the goal, by the truth: the goal radius of the specification.
constexpr double kGoalRadius_m = 0.30;
// What is left beside the disc that fits all the way from start to goal.
constexpr double kClearance_m = 0.10;

struct LidarOptions {
  std::vector<std::string> methods = {"straight", "sectors_only", "sectors"};
  double scan_rate_hz = 10.0;
  double slip_scale = 1.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit(
        "methods", methods,
        Field{
            "",
            "what drives: straight (at the goal, no avoidance), sectors_only (the sector method aimed at the "
            "goal), sectors (the whole stack)",
            {},
            {},
            "straight|sectors_only|sectors"});
    visit("scan_rate_hz", scan_rate_hz, Field{"Hz", "scans a second", 5.5, 10.0});
    visit("slip_scale", slip_scale, Field{"", "scales the wheels' slip; 0 for none", 0.0, 20.0});
  }
  std::string check() const {
    if (methods.empty()) return "methods names none";
    for (const std::string& method : methods) {
      if (method != "straight" && method != "sectors_only" && method != "sectors")
        return "methods: \"" + method + "\" is none of straight, sectors_only, sectors";
    }
    return "";
  }
};

class StraightDriver : public Driver {
 public:
  StraightDriver(const LidarStackParams& params, const RobotModel& robot, const Pose2& odom_from_goal)
      : drive_(params.odometry, params.base, params.mission.xy_aim_m, robot, odom_from_goal) {}

  Twist2 addTicks(const sim::WheelTicks& ticks) override { return drive_.addTicks(ticks); }
  Twist2 addScan(const LaserScan&) override { return drive_.command(); }
  Pose2 odometry() const override { return drive_.odometry(); }
  bool reached() const override { return drive_.reached(); }
  std::string abortReason() const override { return ""; }
  bool stopsAtContact() const override { return true; }

 private:
  StraightDrive drive_;
};

/// The node graph's classes.
class StackDriver : public Driver {
 public:
  StackDriver(const LidarStackParams& params, const RobotModel& robot, const Pose2& odom_from_goal, Stamp now)
      : stack_(params, robot) {
    stack_.setGoal(odom_from_goal, now);
  }
  Twist2 addTicks(const sim::WheelTicks& ticks) override {
    return stack_.addTicks(ticks.stamp, ticks.left, ticks.right).velocity;
  }
  Twist2 addScan(const LaserScan& scan) override {
    recoveries_ = std::max(recoveries_, stack_.mission().recoveries());
    return stack_.addScan(scan).velocity;
  }
  Pose2 odometry() const override { return stack_.odometry().odom_from_base; }
  bool reached() const override { return stack_.mission().status().phase == MissionPhase::kReached; }
  std::string abortReason() const override {
    const MissionStatus& status = stack_.mission().status();
    return status.phase == MissionPhase::kAborted ? status.reason : "";
  }
  int recoveries() const override { return recoveries_; }

 private:
  LidarStack stack_;
  int recoveries_ = 0;
};

std::ofstream openCsv(const std::filesystem::path& path, const char* header) {
  std::ofstream file(path);
  if (!file) throw ConfigError("cannot write " + path.string());
  file << header << "\n";
  return file;
}

void writeTrajectory(const std::filesystem::path& path, const std::vector<sim::GroundTruth>& trajectory) {
  std::ofstream file = openCsv(path, "time_s,x_m,y_m,yaw_rad");
  for (const sim::GroundTruth& truth : trajectory) {
    const Pose2& pose = truth.world_from_base;
    file << toSeconds(truth.stamp) << "," << pose.x_m << "," << pose.y_m << "," << pose.yaw_rad << "\n";
  }
}

void writeWorld(const std::filesystem::path& path, const std::vector<Solid>& solids) {
  std::ofstream file = openCsv(path, "id,kind,x_m,y_m");
  for (std::size_t i = 0; i < solids.size(); ++i) {
    for (const Eigen::Vector2d& corner : solids[i].outline())
      file << i << "," << (solids[i].overhang ? "overhang" : "solid") << "," << corner.x() << ","
           << corner.y() << "\n";
  }
}

/// The rows of one method, for the summary.
struct MethodRows {
  std::vector<double> success, contacts, clearance_m, time_s, sign_changes, length_m;
};

double sum(const std::vector<double>& values) {
  return mean(values).value_or(0.0) * static_cast<double>(values.size());
}

class LidarSuite : public SuiteWithOptions<LidarOptions> {
 public:
  std::string help() const override {
    return "random rooms and corridors, driven by the LIDAR: the sector method against driving straight";
  }
  int defaultTrials() const override { return 200; }

  void prepare(const RunContext& context) override {
    robot_ = loadRobot(context.share_dir + "/urdf/frugal_bot.urdf");
    params_ = loadLidarStack(context.share_dir + "/config");
    trajectory_dir_ = context.trajectory_dir;
  }

  Rows runTrial(const Trial& trial) const override {
    const RandomWorld world = makeRandomWorld(trial.seed, robot_.circumradius_m() + kClearance_m);
    const std::string stem = "lidar_" + std::to_string(trial.index);
    if (!trajectory_dir_.empty()) writeWorld(trajectory_dir_ / (stem + "_world.csv"), world.solids);
    Rows rows;
    for (const std::string& method : options_.methods) {
      Json row;
      row["trial"] = trial.index;
      row["method"] = method;
      row["world_kind"] = world.kind;
      row["path_length_m"] = world.path_length_m;
      row["goal_x_m"] = world.goal.x_m;
      row["goal_y_m"] = world.goal.y_m;
      const DriveRecord record = driveMethod(method, world, trial.seed, row);
      if (!trajectory_dir_.empty()) {
        writeTrajectory(trajectory_dir_ / (stem + "_" + method + ".csv"), record.trajectory);
        row["trajectory"] = "trajectories/" + stem + "_" + method + ".csv";
        row["world"] = "trajectories/" + stem + "_world.csv";
      }
      rows.push_back(row);
    }
    return rows;
  }

  Json summarise(const Rows& rows) const override {
    std::map<std::string, MethodRows> methods;
    for (const Json& row : rows) {
      MethodRows& of = methods[row.at("method").get<std::string>()];
      const bool success = row.at("success");
      of.success.push_back(success ? 1.0 : 0.0);
      of.contacts.push_back(row.at("contacts"));
      of.clearance_m.push_back(row.at("min_clearance_m"));
      of.sign_changes.push_back(row.at("turn_sign_changes"));
      of.length_m.push_back(row.at("length_m"));
      if (success) of.time_s.push_back(row.at("time_s"));
    }
    Json summary;
    for (const std::string& method : options_.methods) {
      const MethodRows& of = methods[method];
      const bool any = !of.success.empty();
      summary["success_" + method] = orNull(mean(of.success));
      summary["contacts_" + method] = any ? Json(static_cast<int>(sum(of.contacts))) : Json();
      summary["min_clearance_" + method + "_m"] =
          any ? Json(*std::min_element(of.clearance_m.begin(), of.clearance_m.end())) : Json();
      summary["mean_time_" + method + "_s"] = orNull(mean(of.time_s));
      summary["turn_sign_changes_per_m_" + method] =
          sum(of.length_m) > 0.0 ? Json(sum(of.sign_changes) / sum(of.length_m)) : Json();
    }
    return summary;
  }

 private:
  std::unique_ptr<Driver> makeDriver(const std::string& method, const Pose2& odom_from_goal,
                                     Stamp now) const {
    if (method == "straight") return std::make_unique<StraightDriver>(params_, robot_, odom_from_goal);
    LidarStackParams params = params_;
    params.avoidance.use_path = method == "sectors";
    params.mission.needs_path = params.avoidance.use_path;
    return std::make_unique<StackDriver>(params, robot_, odom_from_goal, now);
  }

  /// Drives one method through the world and fills its row.
  DriveRecord driveMethod(const std::string& method, const RandomWorld& world, std::uint64_t seed,
                          Json& row) const {
    sim::SimulatorParams simulator_params;
    simulator_params.sensors.imu = false;
    simulator_params.lidar.rate_hz = options_.scan_rate_hz;
    simulator_params.body.slip_scale = options_.slip_scale;
    sim::Simulator simulator(world.scene, robot_, simulator_params, seed, world.start);
    const auto driver = makeDriver(method, world.start.inverse() * world.goal, simulator.stamp());
    const double time_limit_s = 3.0 * world.path_length_m / params_.base.limits.max_v_mps + 30.0;

    DriveRecord record = drive(simulator, *driver, time_limit_s);
    const Pose2 truth = simulator.groundTruth().world_from_base;
    const double goal_error_m = distance(truth, world.goal);
    const Pose2 believed = world.start * driver->odometry();
    row["success"] = record.outcome == "reached" && goal_error_m <= kGoalRadius_m && record.contacts == 0;
    row["outcome"] = record.outcome;
    row["reason"] = record.reason.empty() ? Json() : Json(record.reason);
    row["contacts"] = record.contacts;
    row["touched"] = record.touched.empty() ? Json() : Json(record.touched);
    row["time_s"] = record.time_s;
    row["length_m"] = record.length_m;
    row["goal_error_m"] = goal_error_m;
    row["odometry_error_m"] = distance(truth, believed);
    row["odometry_yaw_error_rad"] = angleBetween(believed.yaw_rad, truth.yaw_rad);
    row["min_clearance_m"] = record.min_clearance_m;
    row["recoveries"] = driver->recoveries();
    row["turn_sign_changes"] = record.turn_sign_changes;
    return record;
  }

  RobotModel robot_;
  LidarStackParams params_;
  std::filesystem::path trajectory_dir_;
};

}  // namespace

std::unique_ptr<Suite> makeLidarSuite() { return std::make_unique<LidarSuite>(); }

}  // namespace frugal_nav::eval
