#include "success_suite.hpp"

#include "camera_drive.hpp"
#include "camera_drivers.hpp"
#include "drive_picture.hpp"
#include "random_paint.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <utility>

#include <opencv2/core/utility.hpp>

#include <frugal_nav/eval/camera_layout.hpp>
#include <frugal_nav/eval/statistics.hpp>
#include <frugal_nav/robot/robot_model.hpp>
#include <frugal_nav/sim/sdf_world.hpp>

namespace frugal_nav::eval {
namespace {

// A success stops this near to the stand-off point, by the truth.
constexpr double kGoalRadius_m = 0.30;
// Widths from wheel to wheel of this robot: what the layouts' gaps are measured in.
constexpr double kRobotWidth_m = 0.25;
// Beyond this odometry, not perception, made a robot stop in the wrong place.
constexpr double kOdometryError_m = 0.15;

struct SuccessOptions {
  std::vector<std::string> methods = {"straight", "camera"};
  std::vector<double> speeds = {0.15, 0.25, 0.35};
  double pipeline_rate = 5.0;
  int width = 416;
  double halt_width = 1.5;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("methods", methods,
          Field{"",
                "what drives: camera (the nodes of hybrid.launch), straight (blind, at the goal)",
                {},
                {},
                "straight|camera"});
    visit("speeds", speeds, Field{"m/s", "cruising speeds, each in the same layouts", 0.05, 0.5});
    visit("pipeline_rate", pipeline_rate,
          Field{"Hz", "images a second; what one shows takes effect one period later; time-outs follow it",
                0.5, 20.0});
    visit("width", width, Field{"px", "columns of the images, three quarters as many rows", 160, 1280});
    visit("halt_width", halt_width,
          Field{"",
                "robot widths below which a gap is not driven through: the layouts' narrowest, the paper's "
                "stress setting",
                1.0, 5.0});
  }
  std::string check() const {
    if (methods.empty()) return "methods names none";
    if (speeds.empty()) return "speeds names none";
    return "";
  }
};

/// "0.15" for keys.
std::string keyOf(double speed_mps) {
  char text[16];
  std::snprintf(text, sizeof text, "%.2f", speed_mps);
  return text;
}

/// Why a trial failed, in a few words that can be counted; empty for a success.
std::string causeOf(const CameraDriveRecord& record, const CameraDriver& driver) {
  if (record.outcome == "contact") {
    if (record.touched == "walker") return record.walked_into > 0 ? "walked into" : "hit the walker";
    if (record.touched == "goal_person") return "hit the goal";
    const bool wall = record.touched.rfind("wall", 0) == 0 || record.touched.rfind("partition", 0) == 0;
    return wall ? "hit a wall" : "hit an obstacle";
  }
  if (record.outcome == "reached") {
    if (record.goal_error_m <= kGoalRadius_m) return "";
    const double odometry_m = distance(record.truth.back(), record.believed.back());
    return odometry_m > kOdometryError_m ? "odometry" : "goal misplaced";
  }
  const std::string trouble = driver.trouble();
  return trouble.empty() ? "time out" : trouble;
}

/// The rows of one method at one speed, for the summary.
struct Cell {
  int successes = 0;
  int trials = 0;
};

class SuccessSuite : public SuiteWithOptions<SuccessOptions> {
 public:
  std::string help() const override {
    return "the paper's trials: to a standing person past obstacles and walkers, by the camera alone";
  }
  int defaultTrials() const override { return 50; }

  void prepare(const RunContext& context) override {
    robot_ = loadRobot(context.share_dir + "/urdf/frugal_bot.urdf");
    params_ = loadCameraStack(context.share_dir);
    params_.planner.halt_width_factor = options_.halt_width;
    textures_ = readTextures(context.share_dir + "/worlds/textures");
    picture_dir_ = context.picture_dir;
    cv::setNumThreads(1);  // the trials are what runs in parallel
  }

  Rows runTrial(const Trial& trial) const override {
    const CameraLayout layout = makeCameraLayout(trial.seed, kRobotWidth_m, textures_);
    Rows rows;
    for (const std::string& method : options_.methods) {
      for (const double speed_mps : options_.speeds) rows.push_back(drive(method, speed_mps, layout, trial));
    }
    return rows;
  }

  Json summarise(const Rows& rows) const override {
    Json summary;
    std::vector<double> errors_m;
    int contacts = 0;
    int walked_into = 0;
    int timeouts = 0;
    std::map<std::string, int> causes;
    for (const Json& row : rows) {
      if (row.at("method") != "camera") continue;
      contacts += row.at("contacts").get<int>();
      walked_into += row.at("walked_into").get<int>();
      timeouts += row.at("outcome") == "time_out" ? 1 : 0;
      if (row.at("outcome") == "reached") errors_m.push_back(row.at("goal_error_m"));
      if (!row.at("success").get<bool>()) ++causes[row.at("cause").get<std::string>()];
    }
    for (const double speed_mps : options_.speeds) summariseSpeed(rows, speed_mps, summary);
    summary["contacts"] = contacts;
    summary["walked_into"] = walked_into;
    summary["timeouts"] = timeouts;
    const auto friedman = cochranQ(outcomes(rows));
    summary["friedman_q"] = friedman ? Json(friedman->statistic) : Json();
    summary["friedman_p"] = friedman ? Json(friedman->p) : Json();
    summary["mean_goal_error_m"] = orNull(mean(errors_m));
    for (const auto& [cause, count] : causes) {
      std::string key = "failed_" + cause;
      std::replace(key.begin(), key.end(), ' ', '_');
      summary[key] = count;
    }
    return summary;
  }

 private:
  Json drive(const std::string& method, double speed_mps, const CameraLayout& layout,
             const Trial& trial) const {
    sim::SimulatorParams simulator_params;
    simulator_params.sensors = {true, false, false, method == "camera", false};
    simulator_params.camera.width_px = options_.width;
    simulator_params.camera.height_px = 3 * options_.width / 4;
    simulator_params.camera.rate_hz = options_.pipeline_rate;
    simulator_params.camera.threads = 1;
    simulator_params.lighting.setting = layout.light;
    sim::Simulator simulator(layout.scene, robot_, simulator_params, trial.seed, layout.start);
    const Pose2 odom_from_goal =
        layout.start.inverse() * Pose2{layout.p_stand_off.x(), layout.p_stand_off.y(), 0.0};
    const std::unique_ptr<CameraDriver> driver =
        method == "straight" ? makeStraightDriver(params_, robot_, speed_mps, odom_from_goal)
                             : makeStackDriver(params_, robot_, speed_mps, options_.pipeline_rate, simulator);
    const double time_limit_s = 3.0 * layout.distance_m / speed_mps + 20.0;
    const CameraDriveRecord record = driveCamera(simulator, layout, *driver, speed_mps, time_limit_s);
    const std::string cause = causeOf(record, *driver);
    if (!cause.empty() && method == "camera" && !picture_dir_.empty()) {
      std::filesystem::create_directories(picture_dir_);
      const std::string name = "trial_" + std::to_string(trial.index) + "_" + keyOf(speed_mps) + ".png";
      const std::string title = "trial " + std::to_string(trial.index) + ", " + keyOf(speed_mps) + " m/s, " +
                                layout.light + ": " + cause;
      writeDrivePicture((picture_dir_ / name).string(), layout, record, *driver, title);
    }
    return toRow(method, speed_mps, layout, trial, record, cause);
  }

  static Json toRow(const std::string& method, double speed_mps, const CameraLayout& layout,
                    const Trial& trial, const CameraDriveRecord& record, const std::string& cause) {
    Json row;
    row["trial"] = trial.index;
    row["method"] = method;
    row["speed_mps"] = speed_mps;
    row["success"] = cause.empty();
    row["outcome"] = record.outcome;
    row["cause"] = cause.empty() ? Json() : Json(cause);
    row["reason"] = record.reason.empty() ? Json() : Json(record.reason);
    row["contacts"] = record.contacts;
    row["walked_into"] = record.walked_into;
    row["touched"] = record.touched.empty() ? Json() : Json(record.touched);
    row["time_s"] = record.time_s;
    row["length_m"] = record.length_m;
    row["goal_error_m"] = record.goal_error_m;
    row["odometry_error_m"] = distance(record.truth.back(), record.believed.back());
    row["distance_m"] = layout.distance_m;
    row["light"] = layout.light;
    row["obstacles"] = static_cast<int>(layout.obstacles.size());
    row["gap_m"] = layout.gap_m;
    row["walker_mps"] = layout.crossing ? Json(layout.crossing->speed_mps) : Json();
    return row;
  }

  Cell count(const Rows& rows, const std::string& method, double speed_mps) const {
    Cell cell;
    for (const Json& row : rows) {
      if (row.at("method") != method || row.at("speed_mps").get<double>() != speed_mps) continue;
      ++cell.trials;
      cell.successes += row.at("success").get<bool>() ? 1 : 0;
    }
    return cell;
  }

  void summariseSpeed(const Rows& rows, double speed_mps, Json& summary) const {
    for (const std::string& method : options_.methods) {
      const Cell cell = count(rows, method, speed_mps);
      const std::string key = (method == "camera" ? "" : "_" + method) + ("_" + keyOf(speed_mps));
      summary["success" + key] =
          cell.trials > 0 ? Json(static_cast<double>(cell.successes) / cell.trials) : Json();
      if (method != "camera" || cell.trials == 0) continue;
      const Interval interval = wilsonInterval(cell.successes, cell.trials);
      summary["success" + key + "_low"] = interval.low;
      summary["success" + key + "_high"] = interval.high;
    }
  }

  /// Success by trial and speed, of the camera's runs.
  std::vector<std::vector<bool>> outcomes(const Rows& rows) const {
    std::map<int, std::vector<bool>> trials;
    for (const Json& row : rows) {
      if (row.at("method") == "camera") trials[row.at("trial").get<int>()].push_back(row.at("success"));
    }
    std::vector<std::vector<bool>> all;
    for (auto& [trial, of_trial] : trials) all.push_back(std::move(of_trial));
    return all;
  }

  RobotModel robot_;
  CameraStackParams params_;
  std::vector<sim::Texture> textures_;
  std::filesystem::path picture_dir_;
};

}  // namespace

std::unique_ptr<Suite> makeSuccessSuite() { return std::make_unique<SuccessSuite>(); }

}  // namespace frugal_nav::eval
