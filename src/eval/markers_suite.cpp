#include "markers_suite.hpp"

#include "marker_drive.hpp"
#include "mrclam_drive.hpp"
#include "node_params.hpp"
#include "random_paint.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <frugal_nav/eval/statistics.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav::eval {
namespace {

// A waypoint counts as reached this near, by the truth: the goal radius of the specification.
constexpr double kGoalRadius_m = 0.30;
// What is left beside the disc that fits along the tour.
constexpr double kClearance_m = 0.15;

struct MarkersOptions {
  std::string mrclam;
  MrclamParams robot;
  int waypoints = 4;
  MarkerDriveParams drive;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("mrclam", mrclam,
          Field{"",
                "folder of a run of the UTIAS MRCLAM data set, unpacked: the filter on every robot in it "
                "instead of drives in simulated halls"});
    visit("robot", robot);
    visit("waypoints", waypoints, Field{"", "of a tour", 1, 20});
    visit("drive", drive);
  }
};

Json rowOf(const MarkerHall& hall, const MarkerDriveRecord& record) {
  const auto reached = std::count_if(record.waypoint_errors_m.begin(), record.waypoint_errors_m.end(),
                                     [](double error_m) { return error_m <= kGoalRadius_m; });
  Json row;
  row["light"] = hall.light;
  row["outcome"] = record.outcome;
  row["reason"] = record.reason.empty() ? Json() : Json(record.reason);
  row["waypoints"] = hall.waypoints.size();
  row["reached"] = reached;
  row["waypoint_errors_m"] = record.waypoint_errors_m;
  row["contacts"] = record.contacts;
  row["touched"] = record.touched.empty() ? Json() : Json(record.touched);
  row["time_s"] = record.time_s;
  row["length_m"] = record.length_m;
  row["markers"] = hall.map.markers.size();
  row["images"] = record.images;
  row["fixes"] = record.fixes;
  row["flips"] = record.flips;
  row["images_near"] = record.near.count();
  row["position_rmse_m"] = record.near.positionRmse_m();
  row["yaw_rmse_deg"] = record.near.yawRmse_deg();
  row["anees_near"] = record.near.anees();
  row["instants"] = record.all.count();
  row["anees"] = record.all.anees();
  row["position_rmse_delayed_m"] = record.delayed.positionRmse_m();
  row["position_rmse_as_printed_m"] = record.printed.positionRmse_m();
  row["yaw_rmse_as_printed_deg"] = record.printed.yawRmse_deg();
  row["drift_no_marker_pct"] = record.drift_pct;
  return row;
}

void writeSamples(const std::filesystem::path& path, const std::vector<MarkerDriveSample>& samples) {
  std::ofstream file(path);
  if (!file) throw ConfigError("cannot write " + path.string());
  file << "time_s,x_m,y_m,yaw_rad,believed_x_m,believed_y_m,believed_yaw_rad,as_printed_x_m,as_printed_y_m,"
          "as_printed_yaw_rad,sigma_m,marker_near\n";
  for (const MarkerDriveSample& sample : samples) {
    file << sample.time_s;
    for (const Pose2& pose : {sample.truth, sample.believed, sample.as_printed})
      file << "," << pose.x_m << "," << pose.y_m << "," << pose.yaw_rad;
    file << "," << sample.sigma_m << "," << sample.is_near << "\n";
  }
}

std::vector<double> column(const Rows& rows, const std::string& key) {
  std::vector<double> values;
  for (const Json& row : rows) values.push_back(row.at(key).get<double>());
  return values;
}

double sum(const Rows& rows, const std::string& key) {
  double total = 0.0;
  for (const double value : column(rows, key)) total += value;
  return total;
}

/// The mean of a column, each row weighted by another; of its squares when `squared`, and their root.
Json pooled(const Rows& rows, const std::string& key, const std::string& weight_key, bool squared) {
  const std::vector<double> values = column(rows, key);
  const std::vector<double> weights = column(rows, weight_key);
  double total = 0.0;
  double weight = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    total += weights[i] * (squared ? values[i] * values[i] : values[i]);
    weight += weights[i];
  }
  if (weight == 0.0) return {};
  return squared ? std::sqrt(total / weight) : total / weight;
}

Json summariseRecordings(const Rows& rows) {
  Json summary;
  for (const char* key : {"position_rmse_m", "yaw_rmse_deg", "anees", "gated_share"})
    summary[key] = orNull(mean(column(rows, key)));
  return summary;
}

Json summariseDrives(const Rows& rows) {
  Json summary;
  for (const char* key : {"yaw_rmse_deg", "position_rmse_m", "position_rmse_delayed_m",
                          "position_rmse_as_printed_m", "yaw_rmse_as_printed_deg"})
    summary[key] = pooled(rows, key, "images_near", true);
  const Json& ours = summary["position_rmse_m"];
  const Json& printed = summary["position_rmse_as_printed_m"];
  summary["as_printed_over_ours"] =
      ours.is_number() && ours > 0.0 ? Json(printed.get<double>() / ours.get<double>()) : Json();
  std::vector<double> drifts;
  std::vector<double> errors;
  for (const Json& row : rows) {
    for (const Json& drift : row.at("drift_no_marker_pct")) drifts.push_back(drift);
    for (const Json& error : row.at("waypoint_errors_m")) errors.push_back(error);
  }
  const auto largest = [](const std::vector<double>& values) {
    return values.empty() ? Json() : Json(*std::max_element(values.begin(), values.end()));
  };
  summary["drift_no_marker_pct"] = orNull(mean(drifts));
  summary["drift_no_marker_max_pct"] = largest(drifts);
  summary["anees"] = pooled(rows, "anees", "instants", false);
  summary["anees_near"] = pooled(rows, "anees_near", "images_near", false);
  summary["flips"] = sum(rows, "flips");
  const double waypoints = sum(rows, "waypoints");
  summary["waypoints_reached"] = waypoints > 0.0 ? Json(sum(rows, "reached") / waypoints) : Json();
  summary["waypoint_error_max_m"] = largest(errors);
  summary["contacts"] = sum(rows, "contacts");
  return summary;
}

class MarkersSuite : public SuiteWithOptions<MarkersOptions> {
 public:
  std::string help() const override {
    return "localization by markers on tours through halls, against the paper's filter; or the filter on "
           "real robots (--mrclam DIR)";
  }
  int defaultTrials() const override { return 50; }

  void prepare(const RunContext& context) override {
    if (!options_.mrclam.empty()) {
      runs_ = readMrclam(options_.mrclam);
      return;
    }
    robot_ = loadRobot(context.share_dir + "/urdf/frugal_bot.urdf");
    textures_ = readTextures(context.share_dir + "/worlds/textures");
    stack_.drive = loadLidarStack(context.share_dir + "/config");
    stack_.localization =
        loadPart<MarkerLocalizationParams>({context.share_dir + "/config/marker_localization.yaml"});
    trajectory_dir_ = context.trajectory_dir;
  }

  Rows runTrial(const Trial& trial) const override {
    return options_.mrclam.empty() ? runDrive(trial) : runRecordings(trial);
  }

  Json summarise(const Rows& rows) const override {
    return options_.mrclam.empty() ? summariseDrives(rows) : summariseRecordings(rows);
  }

 private:
  Rows runDrive(const Trial& trial) const {
    const MarkerHall hall =
        makeMarkerHall(trial.seed, robot_.circumradius_m() + kClearance_m, options_.waypoints, textures_);
    const MarkerDriveRecord record = driveMarkerHall(hall, robot_, stack_, options_.drive, trial.seed);
    Json row = rowOf(hall, record);
    row["trial"] = trial.index;
    if (!trajectory_dir_.empty()) {
      const std::string name = "markers_" + std::to_string(trial.index) + ".csv";
      writeSamples(trajectory_dir_ / name, record.samples);
      row["trajectory"] = "trajectories/" + name;
    }
    return {row};
  }

  /// A recording is the same whatever the seed: the first trial gives a row a robot, others none.
  Rows runRecordings(const Trial& trial) const {
    Rows rows;
    if (trial.index > 0) return rows;
    for (const MrclamRun& run : runs_) {
      const MrclamScore score = scoreMrclam(run, options_.robot);
      Json row;
      row["trial"] = trial.index;
      row["robot"] = run.robot;
      row["position_rmse_m"] = score.position_rmse_m;
      row["yaw_rmse_deg"] = score.yaw_rmse_deg;
      row["anees"] = score.anees;
      row["gated_share"] = score.gated_share;
      rows.push_back(row);
    }
    return rows;
  }

  std::vector<MrclamRun> runs_;
  RobotModel robot_;
  std::vector<sim::Texture> textures_;
  MarkerStackParams stack_;
  std::filesystem::path trajectory_dir_;
};

}  // namespace

std::unique_ptr<Suite> makeMarkersSuite() { return std::make_unique<MarkersSuite>(); }

}  // namespace frugal_nav::eval
