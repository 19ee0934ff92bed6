#include "localization_suite.hpp"

#include "localization_course.hpp"
#include "node_params.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/LU>

#include <frugal_nav/eval/statistics.hpp>
#include <frugal_nav/eval/trajectory_metrics.hpp>
#include <frugal_nav/odometry/wheel_odometry.hpp>
#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav::eval {
namespace {

const char* const kLights[] = {"daylight", "dim", "tube"};
const char* const kMethods[] = {"tracking", "matching"};

struct LocalizationOptions {
  int width_px = 640;
  double speed_mps = 0.3;
  double rate_hz = 10.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("width_px", width_px,
          Field{"px", "width of the images; their height is three quarters of it", 160, 1280});
    visit("speed_mps", speed_mps, Field{"m/s", "speed along a straight", 0.05, 1.0});
    visit("rate_hz", rate_hz, Field{"Hz", "images a second", 1.0, 60.0});
  }
};

/// How far a course's poses are from the truth.
struct PoseErrors {
  double ate_m = 0.0;      ///< root mean square of the positions, which start in the true pose
  double drift_pct = 0.0;  ///< of the end, by the way's length
};

/// `poseOf(i)` is the estimate at image i.
template <class PoseOf>
PoseErrors errorsOf(const DriveRecording& recording, PoseOf poseOf) {
  PoseErrors errors;
  if (recording.images.empty()) return errors;
  std::vector<double> distances;
  for (std::size_t i = 0; i < recording.images.size(); ++i)
    distances.push_back(distance(poseOf(i), recording.images[i].world_from_base));
  errors.ate_m = *rootMeanSquare(distances);
  errors.drift_pct = 100.0 * distances.back() / recording.length_m;
  return errors;
}

/// Normalised squared error of the position over its degrees of freedom, the mean of all images: 1 when the
/// covariance is right. Nothing for no images.
std::optional<double> consistencyOf(const DriveRecording& recording, const VisualDriveResult& result) {
  std::vector<double> values;
  for (std::size_t i = 0; i < recording.images.size(); ++i) {
    const Eigen::Vector2d error =
        result.visual[i].position() - recording.images[i].world_from_base.position();
    const Eigen::Matrix2d covariance = result.outputs[i].covariance.topLeftCorner<2, 2>();
    if (covariance.determinant() > 0.0) values.push_back(0.5 * error.dot(covariance.inverse() * error));
  }
  return mean(values);
}

class LocalizationSuite : public SuiteWithOptions<LocalizationOptions> {
 public:
  std::string help() const override {
    return "wheel odometry, tracking and matching visual odometry on the same drives, in each light";
  }
  int defaultTrials() const override { return 6; }

  void prepare(const RunContext& context) override {
    robot_ = loadRobot(context.share_dir + "/urdf/frugal_bot.urdf");
    stock_ = readTrainingStock(context.share_dir + "/worlds");
    wheels_ = loadPart<WheelOdometryParams>({context.share_dir + "/config/wheel_odometry.yaml",
                                             context.share_dir + "/config/simulated/wheel_odometry.yaml"});
    visual_ = loadPart<VisualOdometryParams>({context.share_dir + "/config/visual_odometry.yaml"});
  }

  Rows runTrial(const Trial& trial) const override {
    const LocalizationPlace place = drawLocalizationPlace(trial.seed, stock_);
    const sim::RayTracer tracer(place.scene);
    Rows rows;
    for (const char* light : kLights) {
      for (const bool is_square : {false, true}) {
        Json row;
        row["trial"] = trial.index;
        row["light"] = light;
        row["course"] = is_square ? "square" : "corner";
        measure(place, is_square ? place.square : place.corner, light, trial.seed, tracer, row);
        rows.push_back(row);
      }
    }
    return rows;
  }

  Json summarise(const Rows& rows) const override {
    std::map<std::string, std::vector<double>> values;
    for (const Json& row : rows) {
      const std::string light = "_" + row.at("light").get<std::string>();
      const bool is_corner = row.at("course") == "corner";
      const auto add = [&](const std::string& key, const std::string& column) {
        const Json& value = row.at(column);
        if (value.is_number()) values[key].push_back(value.get<double>());
      };
      add("ate_wheel_m", "ate_wheel_m");
      add("ate_vo_tracking" + light + "_m", "ate_vo_tracking_m");
      add("ate_vo_matching" + light + "_m", "ate_vo_matching_m");
      if (is_corner) add("drift_wheel_pct", "drift_wheel_pct");
      if (is_corner) add("drift_vo" + light + "_pct", "drift_vo_tracking_pct");
      if (is_corner) add("drift_vo_matching" + light + "_pct", "drift_vo_matching_pct");
      add("map_error" + light + "_m", "map_error_m");
      add("map_points" + light, "map_points");
      add("anees_vo" + light, "anees_vo_tracking");
      add("tracked_tracking" + light, "tracked_tracking");
      add("tracked_matching" + light, "tracked_matching");
    }
    Json summary;
    const auto put = [&](const std::string& key) { summary[key] = orNull(mean(values[key])); };
    put("ate_wheel_m");
    put("drift_wheel_pct");
    for (const std::string light : kLights) {
      for (const std::string& key : {"ate_vo_tracking_" + light + "_m", "ate_vo_matching_" + light + "_m",
                                     "drift_vo_" + light + "_pct", "drift_vo_matching_" + light + "_pct",
                                     "map_error_" + light + "_m", "map_points_" + light, "anees_vo_" + light,
                                     "tracked_tracking_" + light, "tracked_matching_" + light})
        put(key);
    }
    return summary;
  }

 private:
  void measure(const LocalizationPlace& place, const Course& course, const std::string& light,
               std::uint64_t seed, const sim::RayTracer& tracer, Json& row) const {
    sim::SimulatorParams params;
    params.camera.width_px = options_.width_px;
    params.camera.height_px = 3 * options_.width_px / 4;
    params.camera.rate_hz = options_.rate_hz;
    params.camera.threads = 1;  // trials run side by side
    params.lighting.setting = light;
    DriveSpeed speed;
    speed.v_mps = options_.speed_mps;
    const DriveRecording recording =
        recordDrive(place.scene, robot_, params, seed, course.start, course.legs, speed, wheels_);
    row["length_m"] = recording.length_m;
    row["images"] = recording.images.size();
    row["contacts"] = recording.contacts;
    const PoseErrors wheel =
        errorsOf(recording, [&](std::size_t i) { return recording.images[i].odom_from_base; });
    row["ate_wheel_m"] = wheel.ate_m;
    row["drift_wheel_pct"] = wheel.drift_pct;
    for (const std::string method : kMethods) {
      VisualOdometryParams visual = visual_;
      visual.features.method = method;
      const VisualDriveResult result = runVisualOdometry(recording, visual);
      const PoseErrors errors = errorsOf(recording, [&](std::size_t i) { return result.visual[i]; });
      row["ate_vo_" + method + "_m"] = errors.ate_m;
      row["drift_vo_" + method + "_pct"] = errors.drift_pct;
      row["tracked_" + method] = result.tracked_share;
      row["anees_vo_" + method] = orNull(consistencyOf(recording, result));
      if (method != "tracking") continue;
      row["map_error_m"] = orNull(meanDistanceToSurface(result.cloud, tracer));
      row["map_points"] = result.cloud.size();
    }
  }

  RobotModel robot_;
  TrainingStock stock_;
  WheelOdometryParams wheels_;
  VisualOdometryParams visual_;
};

}  // namespace

std::unique_ptr<Suite> makeLocalizationSuite() { return std::make_unique<LocalizationSuite>(); }

}  // namespace frugal_nav::eval
