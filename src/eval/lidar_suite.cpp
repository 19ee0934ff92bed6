#include "lidar_suite.hpp"

#include "lidar_drive.hpp"
#include "lidar_worlds.hpp"
#include "stack_driver.hpp"
#include "straight_drive.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/eval/statistics.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav::eval {
namespace {

// A success ends this near to the goal, by the truth: the goal radius of the specification.
constexpr double kGoalRadius_m = 0.30;
// What is left beside the disc that fits all the way from start to goal.
constexpr double kClearance_m = 0.10;

const std::vector<std::string> kParts = {"rooms", "doorway", "moving", "near_target"};

bool isAmong(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

struct LidarOptions {
  std::vector<std::string> methods = {"sectors", "vfh_plus", "vfh_star", "dwa"};
  std::vector<std::string> parts = kParts;
  double scan_rate_hz = 10.0;
  double slip_scale = 1.0;
  double door_spare_m = 0.04;
  double target_gap_m = 0.35;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit(
        "methods", methods,
        Field{
            "",
            "what drives: straight (at the goal, no avoidance), sectors_only (the sector method aimed at the "
            "goal), or the whole stack with a method of lidar_avoidance",
            {},
            {},
            "straight|sectors_only|sectors|vfh_plus|vfh_star|dwa"});
    visit("parts", parts,
          Field{"",
                "rooms (and corridors), doorway (two rooms), moving (people and a cylinder cross), "
                "near_target (a "
                "thing beside the goal)",
                {},
                {},
                "rooms|doorway|moving|near_target"});
    visit("scan_rate_hz", scan_rate_hz, Field{"Hz", "scans a second", 5.5, 10.0});
    visit("slip_scale", slip_scale, Field{"", "scales the wheels' slip; 0 for none", 0.0, 20.0});
    visit("door_spare_m", door_spare_m, Field{"m", "what the doorway is wider than the robot", 0.01, 1.0});
    visit("target_gap_m", target_gap_m,
          Field{"m", "from the goal to the surface of the thing beside it", 0.0, 2.0});
  }
  std::string check() const {
    if (methods.empty()) return "methods names none";
    if (parts.empty()) return "parts names none";
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

void writeWorld(const std::filesystem::path& path, const std::vector<Solid>& solids) {
  std::ofstream file = openCsv(path, "id,kind,x_m,y_m");
  for (std::size_t i = 0; i < solids.size(); ++i) {
    for (const Eigen::Vector2d& corner : solids[i].outline())
      file << i << "," << (solids[i].overhang ? "overhang" : "solid") << "," << corner.x() << ","
           << corner.y() << "\n";
  }
}

/// Rows of one method, for the summary.
struct MethodRows {
  std::vector<double> success, contacts, clearance_m, time_s, sign_changes, length_m;
};

double sum(const std::vector<double>& values) {
  return mean(values).value_or(0.0) * static_cast<double>(values.size());
}

MethodRows collect(const Rows& rows, const std::string& method, const std::vector<std::string>& parts) {
  MethodRows of;
  for (const Json& row : rows) {
    if (row.at("method") != method || !isAmong(parts, row.at("part"))) continue;
    const bool success = row.at("success");
    of.success.push_back(success ? 1.0 : 0.0);
    of.contacts.push_back(row.at("contacts"));
    of.clearance_m.push_back(row.at("min_clearance_m"));
    of.sign_changes.push_back(row.at("turn_sign_changes"));
    of.length_m.push_back(row.at("length_m"));
    if (success) of.time_s.push_back(row.at("time_s"));
  }
  return of;
}

Json total(const std::vector<double>& values) {
  return values.empty() ? Json() : Json(static_cast<int>(sum(values)));
}

class LidarSuite : public SuiteWithOptions<LidarOptions> {
 public:
  std::string help() const override {
    return "random rooms, corridors and doorways, people that cross, and goals beside things, driven by the "
           "LIDAR";
  }
  int defaultTrials() const override { return 100; }

  void prepare(const RunContext& context) override {
    robot_ = loadRobot(context.share_dir + "/urdf/frugal_bot.urdf");
    params_ = loadLidarStack(context.share_dir + "/config");
    trajectory_dir_ = context.trajectory_dir;
  }

  Rows runTrial(const Trial& trial) const override {
    Rows rows;
    for (const std::string& part : options_.parts) {
      const LidarWorld world = makeWorld(part, trial.seed);
      const std::string stem = "lidar_" + part + "_" + std::to_string(trial.index);
      if (!trajectory_dir_.empty()) writeWorld(trajectory_dir_ / (stem + "_world.csv"), world.place.solids);
      for (const std::string& method : options_.methods) {
        Json row;
        row["trial"] = trial.index;
        row["part"] = part;
        row["method"] = method;
        row["world_kind"] = world.place.kind;
        row["path_length_m"] = world.place.path_length_m;
        row["goal_x_m"] = world.place.goal.x_m;
        row["goal_y_m"] = world.place.goal.y_m;
        const DriveRecord record = driveMethod(method, world, trial.seed, row);
        if (!trajectory_dir_.empty()) {
          writeTrajectory(trajectory_dir_ / (stem + "_" + method + ".csv"), record.trajectory);
          row["trajectory"] = "trajectories/" + stem + "_" + method + ".csv";
          row["world"] = "trajectories/" + stem + "_world.csv";
        }
        rows.push_back(row);
      }
    }
    return rows;
  }

  Json summarise(const Rows& rows) const override {
    Json summary;
    for (const std::string& method : options_.methods) {
      const MethodRows standing = collect(rows, method, {"rooms", "doorway"});
      summary["success_" + method] = orNull(mean(standing.success));
      summary["contacts_" + method] = total(standing.contacts);
      summary["min_clearance_" + method + "_m"] =
          standing.clearance_m.empty()
              ? Json()
              : Json(*std::min_element(standing.clearance_m.begin(), standing.clearance_m.end()));
      summary["mean_time_" + method + "_s"] = orNull(mean(standing.time_s));
      summary["turn_sign_changes_per_m_" + method] =
          sum(standing.length_m) > 0.0 ? Json(sum(standing.sign_changes) / sum(standing.length_m)) : Json();
      for (const std::string part : {"doorway", "moving", "near_target"}) {
        if (!isAmong(options_.parts, part)) continue;
        const MethodRows of = collect(rows, method, {part});
        summary["success_" + part + "_" + method] = orNull(mean(of.success));
        summary["contacts_" + part + "_" + method] = total(of.contacts);
      }
    }
    return summary;
  }

 private:
  LidarWorld makeWorld(const std::string& part, std::uint64_t seed) const {
    if (part == "doorway") return makeDoorwayWorld(seed, 2.0 * robot_.halfWidth_m() + options_.door_spare_m);
    if (part == "moving") return makeMovingWorld(seed);
    if (part == "near_target") return makeNearTargetWorld(seed, options_.target_gap_m);
    return {makeRandomWorld(seed, robot_.circumradius_m() + kClearance_m), {}};
  }

  std::unique_ptr<Driver> makeDriver(const std::string& method, const Pose2& odom_from_goal,
                                     Stamp now) const {
    if (method == "straight") return std::make_unique<StraightDriver>(params_, robot_, odom_from_goal);
    LidarStackParams params = params_;
    params.avoidance.use_path = method != "sectors_only";
    params.avoidance.method = method == "sectors_only" ? "sectors" : method;
    params.mission.needs_path = params.avoidance.use_path;
    return std::make_unique<StackDriver>(params, robot_, odom_from_goal, now);
  }

  /// Drives one method through the world and fills its row.
  DriveRecord driveMethod(const std::string& method, const LidarWorld& lidar_world, std::uint64_t seed,
                          Json& row) const {
    const RandomWorld& world = lidar_world.place;
    sim::SimulatorParams simulator_params;
    simulator_params.sensors.imu = false;
    simulator_params.lidar.rate_hz = options_.scan_rate_hz;
    simulator_params.body.slip_scale = options_.slip_scale;
    sim::Simulator simulator(world.scene, robot_, simulator_params, seed, world.start);
    const auto driver = makeDriver(method, world.start.inverse() * world.goal, simulator.stamp());
    const double time_limit_s = 3.0 * world.path_length_m / params_.base.limits.max_v_mps + 30.0;

    DriveRecord record =
        drive(simulator, *driver, time_limit_s, [&] { moveAll(lidar_world.movers, simulator); });
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
