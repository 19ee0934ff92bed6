#include "depth_suite.hpp"

#include "depth_drive.hpp"
#include "depth_scene.hpp"
#include "node_params.hpp"
#include "random_paint.hpp"
#include "rgbd_depth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/imgproc.hpp>

#include <frugal_nav/eval/statistics.hpp>
#include <frugal_nav/eval/trajectory_metrics.hpp>
#include <frugal_nav/eval/view_truth.hpp>
#include <frugal_nav/eval/visual_drive.hpp>
#include <frugal_nav/perception/depth_choice.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kDistances_m[] = {0.6, 0.9, 1.2, 1.5, 1.8, 2.1, 2.4};
constexpr int kDistances = 7;
constexpr int kImages = 10;
constexpr double kUnscaledAt_m = 1.5;  // where the one scale of the unscaled network is fitted

struct DepthOptions {
  std::string model = "depth_small";
  std::string model_file;
  std::string rgbd;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("model", model, Field{"", "the depth network: one of config/models/NAME.yaml"});
    visit("model_file", model_file, Field{"", "where the network lies; empty: where its yaml says"});
    visit("rgbd", rgbd,
          Field{"",
                "folder of a real recording (images, depth in mm, K.txt, poses.txt) to measure on instead"});
  }
};

double medianOf(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Json finiteOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(); }

/// Cells of the working grid that show one model alone; the best there are when none does.
cv::Mat cellsOf(const cv::Mat& models, int model, const cv::Size& grid) {
  cv::Mat shows;
  cv::Mat(models == model).convertTo(shows, CV_32F, 1.0 / 255.0);
  cv::Mat share;
  cv::resize(shows, share, grid, 0.0, 0.0, cv::INTER_AREA);
  double most = 0.0;
  cv::minMaxLoc(share, nullptr, &most);
  return share >= std::min(0.99, most) - 1e-6;
}

/// Leaves the cells that show what can touch the robot.
void keepLow(const cv::Mat& true_m, const ViewRays& rays, cv::Mat& cells) {
  const auto height_m = static_cast<float>(DepthScanParams{}.max_height_m);
  for (int row = 0; row < cells.rows; ++row) {
    for (int column = 0; column < cells.cols; ++column) {
      if (rays.heightAt(row, column, true_m.at<float>(row, column)) > height_m)
        cells.at<uchar>(row, column) = 0;
    }
  }
}

/// Median over the cells of a mask; NaN when the map is empty.
double medianWithin(const cv::Mat& map, const cv::Mat& cells) {
  std::vector<double> values;
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.cols; ++column) {
      const float value = map.at<float>(row, column);
      if (cells.at<uchar>(row, column) != 0 && std::isfinite(value))
        values.push_back(static_cast<double>(value));
    }
  }
  return medianOf(std::move(values));
}

/// Sums of the errors of one method, as the paper's table has them.
struct Errors {
  std::vector<double> absolute;
  std::vector<double> relative;

  void add(const Json& estimate, double truth) {
    if (!estimate.is_number()) return;
    absolute.push_back(std::abs(estimate.get<double>() - truth));
    relative.push_back(absolute.back() / truth);
  }
  void write(const std::string& name, Json& summary) const {
    summary["mae_" + name + "_m"] = orNull(mean(absolute));
    summary["rmse_" + name + "_m"] = orNull(rootMeanSquare(absolute));
    summary["rel_" + name] = orNull(mean(relative));
  }
};

class DepthSuite : public SuiteWithOptions<DepthOptions> {
 public:
  std::string help() const override {
    return "depth of a thing 0.6 to 2.4 m ahead after a short drive: network alone, scaled by visual "
           "odometry, "
           "fused";
  }
  int defaultTrials() const override { return options_.rgbd.empty() ? kDistances * kImages : 1; }

  void prepare(const RunContext& context) override {
    robot_ = loadRobot(context.share_dir + "/urdf/frugal_bot.urdf");
    wheels_ = loadPart<WheelOdometryParams>({context.share_dir + "/config/wheel_odometry.yaml",
                                             context.share_dir + "/config/simulated/wheel_odometry.yaml"});
    textures_ = readTextures(context.share_dir + "/worlds/textures");
    share_dir_ = context.share_dir;
    choice_.model = options_.model;
    choice_.model_file = options_.model_file;
    makeDepthNetwork(choice_, share_dir_);  // a wrong one shows before the trials
    if (!options_.rgbd.empty()) recording_ = readRgbdRecording(options_.rgbd);
  }

  Rows runTrial(const Trial& trial) const override {
    if (options_.rgbd.empty()) return {measureScene(trial)};
    // A recording is one trial: it has no seeds.
    return trial.index == 0
               ? measureRgbd(recording_, *makeDepthNetwork(choice_, share_dir_), DepthGapParams{})
               : Rows{};
  }

  Json summarise(const Rows& rows) const override {
    return options_.rgbd.empty() ? summariseScenes(rows) : summariseRecording(rows);
  }

 private:
  Json measureScene(const Trial& trial) const {
    const double distance_m = kDistances_m[static_cast<std::size_t>(trial.index % kDistances)];
    const Eigen::Isometry3d base_from_optical = robot_.baseFrom("camera_optical_frame");
    const DepthScene place =
        makeDepthScene(trial.seed, distance_m, base_from_optical.translation().x(), textures_);
    sim::SimulatorParams params;
    params.lighting.setting = place.light;
    params.camera.threads = 1;
    const DriveRecording recording =
        recordDrive(place.scene, robot_, params, trial.seed, place.start, place.legs, {0.25, 0.5}, wheels_);

    SharedDepthNetwork network(makeDepthNetwork(choice_, share_dir_));
    DepthGapParams vo_params;
    vo_params.method = "vo";
    DepthGap by_vo(network.answer(), vo_params);
    DepthGap fused(network.answer(), DepthGapParams{});
    VisualOdometry odometry(VisualOdometryParams{}, recording.camera, recording.base_from_camera);
    DepthFrame vo_frame;
    DepthFrame fused_frame;
    VisualOdometryOutput visual;
    for (const DriveImage& image : recording.images) {
      visual = odometry.process(
          {image.stamp, image.bgr, toIsometry(image.odom_from_base), regionOf(fused_frame.obstacle)});
      network.show(image.bgr);
      const DepthView view{
          image.stamp,          image.bgr,
          recording.camera,     recording.base_from_camera,
          image.odom_from_base, metricPoints(visual, recording.base_from_camera, image.odom_from_base),
          std::nullopt};
      vo_frame = by_vo.look(view);
      fused_frame = fused.look(view);
    }
    return measure(trial, place, distance_m, recording, vo_frame, fused_frame, visual);
  }

  /// True and estimated places of the frames that visual odometry tracked.
  static std::vector<PosePair> trackedPoses(const Rows& rows) {
    std::vector<PosePair> pairs;
    for (const Json& row : rows) {
      if (row["vo_state"] != text(VisualState::kTracking)) continue;
      PosePair pair;
      for (int k = 0; k < 3; ++k) {
        const auto i = static_cast<std::size_t>(k);
        pair.reference.translation()[k] = row["true_m"][i].get<double>();
        pair.estimate.translation()[k] = row["vo_m"][i].get<double>();
      }
      pairs.push_back(pair);
    }
    return pairs;
  }

  /// Over the frames for which visual odometry gave a scale; visual odometry itself over those it tracked,
  /// after a similarity transform.
  static Json summariseRecording(const Rows& rows) {
    std::map<std::string, std::vector<double>> errors;
    for (const Json& row : rows) {
      if (!row["rel_fused"].is_number()) continue;
      for (const char* key : {"rel_network", "rel_median", "rel_fused"})
        errors[key].push_back(row[key].get<double>());
    }
    Json summary;
    for (const char* key : {"rel_network", "rel_median", "rel_fused"})
      summary[key] = orNull(mean(errors[key]));
    const std::vector<PosePair> tracked = trackedPoses(rows);
    const auto alignment = align(tracked, AlignmentKind::kSimilarity);
    summary["vo_tracked"] =
        rows.empty() ? Json() : Json(static_cast<double>(tracked.size()) / static_cast<double>(rows.size()));
    summary["vo_ate_m"] = alignment ? Json(absoluteError(tracked, *alignment).rmse) : Json();
    const std::size_t scaled = errors["rel_fused"].size();
    summary["frames"] = rows.size();
    summary["share_with_scale"] =
        rows.empty() ? Json() : Json(static_cast<double>(scaled) / static_cast<double>(rows.size()));
    return summary;
  }

  static Json summariseScenes(const Rows& rows) {
    std::vector<double> scales;  // of the network alone, where the one for all is fitted
    for (const Json& row : rows) {
      if (row["distance_m"] == kUnscaledAt_m && row["inverse"].is_number())
        scales.push_back(row["true_m"].get<double>() * row["inverse"].get<double>());
    }
    const double scale = medianOf(scales);
    Errors unscaled, vo, fused;
    for (const Json& row : rows) {
      const auto truth = row["true_m"].get<double>();
      const Json& inverse = row["inverse"];
      if (inverse.is_number()) unscaled.add(finiteOrNull(scale / inverse.get<double>()), truth);
      vo.add(row["vo_m"], truth);
      fused.add(row["fused_m"], truth);
    }
    Json summary;
    unscaled.write("unscaled", summary);
    vo.write("vo", summary);
    fused.write("fused", summary);
    const auto share = [&rows](const Errors& errors) {
      return rows.empty()
                 ? Json()
                 : Json(static_cast<double>(errors.absolute.size()) / static_cast<double>(rows.size()));
    };
    summary["images"] = rows.size();
    summary["share_vo"] = share(vo);
    summary["share_fused"] = share(fused);
    return summary;
  }

  /// Medians over the grid's cells that show the object up to the robot's height: of the truth, as seen by
  /// the tracer from where the robot truly is, and of each estimate.
  Json measure(const Trial& trial, const DepthScene& place, double distance_m,
               const DriveRecording& recording, const DepthFrame& vo, const DepthFrame& fused,
               const VisualOdometryOutput& visual) const {
    const Pinhole& camera = recording.camera;
    Viewpoint view;
    view.size_px = {camera.width_px, camera.height_px};
    view.camera_matrix = {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
    view.distortion = {camera.k1, camera.k2, camera.p1, camera.p2, camera.k3};
    view.world_from_optical =
        toIsometry(recording.images.back().world_from_base) * recording.base_from_camera;
    const sim::RayTracer tracer(place.scene);
    const ViewTruth truth = traceTruth(tracer, view);
    cv::Mat cells = cellsOf(truth.model, place.object_model, fused.inverse.size());
    cv::Mat true_m;
    cv::resize(truth.depth_m, true_m, fused.inverse.size(), 0.0, 0.0, cv::INTER_NEAREST);
    keepLow(true_m, ViewRays(camera, recording.base_from_camera, cells.size()), cells);
    Json row;
    row["trial"] = trial.index;
    row["distance_m"] = distance_m;
    row["object"] = place.object;
    row["light"] = place.light;
    row["true_m"] = medianWithin(true_m, cells);
    row["inverse"] = finiteOrNull(medianWithin(fused.inverse, cells));
    row["vo_m"] = finiteOrNull(medianWithin(vo.depth_m, cells));
    row["fused_m"] = finiteOrNull(medianWithin(fused.depth_m, cells));
    row["obstacle_m"] = finiteOrNull(fused.obstacle.distance_m);
    row["source"] = fused.obstacle.source;
    row["vo_points"] = visual.points.size();
    row["vo_state"] = text(visual.status.state);
    row["vo_reason"] = text(visual.status.reason);
    return row;
  }

  RobotModel robot_;
  WheelOdometryParams wheels_;
  std::vector<sim::Texture> textures_;
  DepthChoice choice_;
  std::string share_dir_;
  RgbdRecording recording_;
};

}  // namespace

std::unique_ptr<Suite> makeDepthSuite() { return std::make_unique<DepthSuite>(); }

}  // namespace frugal_nav::eval
