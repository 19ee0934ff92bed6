#include "barn_suite.hpp"

#include "barn_drive.hpp"
#include "barn_worlds.hpp"
#include "node_params.hpp"
#include "stack_driver.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <frugal_nav/eval/statistics.hpp>
#include <frugal_nav/sim/simulator.hpp>
#include <frugal_nav/sim/world_cache.hpp>

namespace frugal_nav::eval {
namespace {

const Pose2 kStart{-2.25, 3.0, M_PI_2};
constexpr double kGoalAhead_m = 10.0;

struct BarnOptions {
  std::string worlds;
  std::vector<std::string> methods = {"vfh_star"};
  std::vector<double> speeds_mps = {0.5, 2.0};
  double slip_scale = 0.0;
  BarnRules rules;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("worlds", worlds,
          Field{"", "folder of world_NUMBER.world files, with path_lengths.csv in it or beside it"});
    visit("methods", methods,
          Field{"",
                "methods of lidar_avoidance; the first one's keys bear no name, the others' their own",
                {},
                {},
                "vfh_star|vfh_plus|dwa|sectors"});
    visit("speeds_mps", speeds_mps, Field{"m/s", "speed caps", 0.1, 2.0});
    visit("slip_scale", slip_scale,
          Field{"", "scales the wheels' slip, which the rules have none of", 0.0, 20.0});
    visit("rules", rules);
  }
  std::string check() const {
    if (methods.empty()) return "methods names none";
    if (speeds_mps.empty()) return "speeds_mps names none";
    return "";
  }
};

/// A speed as the summary's keys name it: 0.5, 2.0.
std::string nameOf(double speed_mps) {
  char text[16];
  std::snprintf(text, sizeof(text), "%.1f", speed_mps);
  return text;
}

class BarnSuite : public SuiteWithOptions<BarnOptions> {
 public:
  std::string help() const override {
    return "worlds of the BARN challenge (--worlds DIR) by its rules, in this package's simulator";
  }
  int defaultTrials() const override { return worlds_.empty() ? 50 : static_cast<int>(worlds_.size()); }

  void prepare(const RunContext& context) override {
    if (options_.worlds.empty())
      throw ConfigError("barn: --worlds DIR is missing, a folder with world_NUMBER.world files");
    worlds_ = listBarnWorlds(options_.worlds);
    robot_ = loadRobot(context.share_dir + "/urdf/barn_robot.urdf");
    params_ = loadLidarStack(context.share_dir + "/config", "barn");
    simulator_ = loadPart<sim::SimulatorParams>({context.share_dir + "/config/barn/simulator.yaml"});
    simulator_.body.slip_scale = options_.slip_scale;
    trajectory_dir_ = context.trajectory_dir;
  }

  /// Trial k drives the world k; more trials than worlds go through them again with other noise.
  Rows runTrial(const Trial& trial) const override {
    const BarnWorld& world = worlds_[static_cast<std::size_t>(trial.index) % worlds_.size()];
    const sim::LoadedWorld loaded = sim::loadWorldCached(world.path, {}, sim::defaultCacheFolder());
    Rows rows;
    for (const std::string& method : options_.methods) {
      for (const double speed_mps : options_.speeds_mps) {
        Json row;
        row["trial"] = trial.index;
        row["world"] = world.number;
        row["method"] = method;
        row["speed_mps"] = speed_mps;
        driveWorld(world, loaded.scene, trial.seed, row);
        rows.push_back(row);
      }
    }
    return rows;
  }

  Json summarise(const Rows& rows) const override {
    Json summary;
    for (const std::string& method : options_.methods) {
      const std::string prefix = method == options_.methods.front() ? "" : method + "_";
      for (const double speed_mps : options_.speeds_mps) {
        Rows some;
        std::copy_if(rows.begin(), rows.end(), std::back_inserter(some), [&](const Json& row) {
          return row.at("method") == method && row.at("speed_mps") == speed_mps;
        });
        summariseSome(some, prefix, nameOf(speed_mps), summary);
      }
    }
    return summary;
  }

 private:
  static void summariseSome(const Rows& rows, const std::string& prefix, const std::string& speed,
                            Json& summary) {
    std::vector<double> success, k2, k4, time_s;
    int collisions = 0;
    int timeouts = 0;
    for (const Json& row : rows) {
      success.push_back(row.at("success") ? 1.0 : 0.0);
      k2.push_back(row.at("metric_k2"));
      k4.push_back(row.at("metric_k4"));
      collisions += row.at("outcome") == "contact" ? 1 : 0;
      timeouts += row.at("outcome") == "time_out" ? 1 : 0;
      if (row.at("success")) time_s.push_back(row.at("time_s"));
    }
    const auto key = [&](const std::string& name) { return name + "_" + prefix + speed; };
    summary[key("success")] = orNull(mean(success));
    summary[key("collisions")] = rows.empty() ? Json() : Json(collisions);
    summary[key("timeouts")] = rows.empty() ? Json() : Json(timeouts);
    summary[key("metric_k2")] = orNull(mean(k2));
    summary[key("metric_k4")] = orNull(mean(k4));
    summary[key("mean_time") + "_s"] = orNull(mean(time_s));
  }

  void driveWorld(const BarnWorld& world, const sim::Scene& scene, std::uint64_t seed, Json& row) const {
    const double speed_mps = row.at("speed_mps");
    const std::string method = row.at("method");
    LidarStackParams params = params_;
    params.avoidance.method = method;
    params.avoidance.speed.max_v_mps = speed_mps;
    params.avoidance.right_of_way.cruise_mps = speed_mps;
    params.base.limits.max_v_mps = speed_mps;
    sim::Simulator simulator(scene, robot_, simulator_, seed, kStart);
    const Pose2 odom_from_goal{0.0, kGoalAhead_m, M_PI_2};
    StackDriver driver(params, robot_, odom_from_goal, simulator.stamp());
    const Eigen::Vector2d p_world_goal = kStart * Eigen::Vector2d(kGoalAhead_m, 0.0);

    const DriveRecord record = driveBarn(simulator, driver, p_world_goal, speed_mps, options_.rules);
    const bool success = record.outcome == "reached";
    row["success"] = success;
    row["outcome"] = record.outcome;
    row["reason"] = record.reason.empty() ? Json() : Json(record.reason);
    row["touched"] = record.touched.empty() ? Json() : Json(record.touched);
    row["time_s"] = record.time_s;
    row["path_length_m"] = world.path_length_m;
    row["length_m"] = record.length_m;
    row["min_clearance_m"] = record.min_clearance_m;
    row["recoveries"] = driver.recoveries();
    row["metric_k2"] = barnScore(success, record.time_s, world.path_length_m, 2.0);
    row["metric_k4"] = barnScore(success, record.time_s, world.path_length_m, 4.0);
    if (!trajectory_dir_.empty()) row["trajectory"] = writeTrack(world, row, record.trajectory);
  }

  std::string writeTrack(const BarnWorld& world, const Json& row,
                         const std::vector<sim::GroundTruth>& trajectory) const {
    const std::string name = "barn_" + std::to_string(world.number) + "_" +
                             row.at("method").get<std::string>() + "_" + nameOf(row.at("speed_mps")) + ".csv";
    writeTrajectory(trajectory_dir_ / name, trajectory);
    return "trajectories/" + name;
  }

  std::vector<BarnWorld> worlds_;
  RobotModel robot_;
  LidarStackParams params_;
  sim::SimulatorParams simulator_;
  std::filesystem::path trajectory_dir_;
};

}  // namespace

std::unique_ptr<Suite> makeBarnSuite() { return std::make_unique<BarnSuite>(); }

}  // namespace frugal_nav::eval
