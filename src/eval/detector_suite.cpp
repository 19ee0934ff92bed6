#include "detector_suite.hpp"

#include "detector_view.hpp"
#include "node_params.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <frugal_nav/eval/statistics.hpp>
#include <frugal_nav/eval/stopwatch.hpp>
#include <frugal_nav/perception/detector_choice.hpp>
#include <frugal_nav/perception/head_range.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kNearest_m = 2.0;
constexpr double kMiddle_m = 4.0;
constexpr double kFarthest_m = 6.0;
constexpr double kMostlyVisible = 0.5;  // share of a target that must be found

struct DetectorOptions {
  DetectorChoice detector;
  std::string target = "head";
  int views = 2;
  int frames = 10;
  int width_px = 640;

  template <class Visitor>
  void fields(Visitor&& visit) {
    const double infinity = std::numeric_limits<double>::infinity();
    detector.fields(visit);
    visit("target", target,
          Field{"", "what the detector's boxes are compared with", -infinity, infinity, "head|person"});
    visit("views", views, Field{"", "views of each scene", 1, 20});
    visit("frames", frames, Field{"", "frames of a view that the distance is averaged over", 1, 100});
    visit("width_px", width_px,
          Field{"px", "width of the images; their height is three quarters of it", 160, 1920});
  }
};

/// A person in a view and what was made of it, frame after frame.
struct Target {
  PersonBox truth;  ///< in the first frame
  bool was_found = false;
  std::vector<double> range_ratios;     ///< range found over the true one
  std::vector<double> height_ratios;    ///< of the box likewise
  std::vector<double> true_box_ratios;  ///< range from the true box over the true one: what the detector
                                        ///< cannot be blamed for
};

bool mustBeFound(const PersonBox& box) {
  return box.distance_m >= kNearest_m && box.distance_m <= kFarthest_m && box.visible >= kMostlyVisible;
}

class DetectorSuite : public SuiteWithOptions<DetectorOptions> {
 public:
  std::string help() const override {
    return "a detector on unseen scenes: average precision, and the error of the distances from its boxes";
  }
  int defaultTrials() const override { return 60; }

  void prepare(const RunContext& context) override {
    share_dir_ = context.share_dir;
    stock_ = readTrainingStock(share_dir_ + "/worlds");
    model_ = readParamFile(configOf(options_.detector, share_dir_));
    range_ = loadPart<HeadRangeParams>({share_dir_ + "/config/goal_detector.yaml"}, "head/");
    if (options_.target == "person") {  // as config/goal_detector.yaml says
      range_.head_height_m = 1.65;
      range_.head_depth_m = 0.0;
      range_.min_above_floor_m = 0.5;
      range_.max_above_floor_m = 1.2;
    }
    // Distances are from below the camera, as those of the truth.
    below_from_optical_ = loadRobot(share_dir_ + "/urdf/frugal_bot.urdf").baseFrom("camera_optical_frame");
    below_from_optical_.translation().head<2>().setZero();
    detect_ms_ = measureTime();
  }

  Rows runTrial(const Trial& trial) const override {
    const TrainingScene place = makeUnseenScene(trial.seed, stock_);
    const sim::RayTracer tracer(place.scene);
    const auto detector = makeDetector(model_, options_.detector, share_dir_);
    Rows rows;
    rows.push_back({{"trial", trial.index}, {"kind", "scene"}, {"detect_ms", detect_ms_}});
    for (int number = 0; number < options_.views; ++number) {
      auto view = DetectorView::draw(place, tracer, below_from_optical_, options_.width_px,
                                     options_.target == "head", trial.seed, number);
      if (!view) continue;
      Rows seen = look(*view, *detector);
      for (Json& row : seen) {
        Json full = {{"trial", trial.index}, {"view", number}, {"light", view->light()}};
        full.update(row);
        rows.push_back(full);
      }
    }
    return rows;
  }

  Json summarise(const Rows& rows) const override {
    std::vector<JudgedDetection> detections;
    int targets = 0;
    std::vector<double> near_pct, far_pct, true_box_pct, heights, times_ms;
    for (const Json& row : rows) {
      const std::string kind = row.at("kind");
      if (kind == "scene") times_ms.push_back(row.at("detect_ms"));
      if (kind == "detection") detections.push_back({row.at("score"), row.at("is_hit")});
      if (kind != "target") continue;
      ++targets;
      if (row.at("true_box_error_pct").is_number())
        true_box_pct.push_back(std::abs(row.at("true_box_error_pct").get<double>()));
      if (row.at("height_ratio").is_number()) heights.push_back(row.at("height_ratio"));
      if (!row.at("error_pct").is_number()) continue;
      const double error_pct = std::abs(row.at("error_pct").get<double>());
      (row.at("distance_m") <= kMiddle_m ? near_pct : far_pct).push_back(error_pct);
    }
    const auto time_ms = mean(times_ms);
    Json summary;
    summary["ap50"] = orNull(averagePrecision(detections, targets));
    summary["distance_error_2_4m_pct"] = orNull(mean(near_pct));
    summary["distance_error_4_6m_pct"] = orNull(mean(far_pct));
    summary["frames_per_s"] = time_ms ? Json(1000.0 / *time_ms) : Json();
    summary["targets"] = targets;
    summary["ranged_2_4m"] = near_pct.size();
    summary["ranged_4_6m"] = far_pct.size();
    summary["distance_error_true_box_pct"] = orNull(mean(true_box_pct));
    summary["height_ratio"] = orNull(mean(heights));
    return summary;
  }

 private:
  /// Time of one image with nothing else running, in wall time [ms].
  double measureTime() const {
    const auto detector = makeDetector(model_, options_.detector, share_dir_);
    cv::Mat noise(3 * options_.width_px / 4, options_.width_px, CV_8UC3);
    cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 255);
    constexpr int kImages = 20;
    detector->detect(noise);
    const double begin_ms = wallTime_ms();
    for (int i = 0; i < kImages; ++i) detector->detect(noise);
    return (wallTime_ms() - begin_ms) / kImages;
  }

  /// The frames of a view: detections of the first, and each target with its distance averaged over all.
  Rows look(DetectorView& view, Detector& detector) const {
    const HeadRange range(range_, view.pinhole(), below_from_optical_);
    Rows rows;
    std::vector<Target> targets;
    for (int k = 0; k < options_.frames; ++k) {
      const DetectorView::Frame frame = view.next();
      const std::vector<Detection> detections = detector.detect(frame.bgr);
      const std::vector<int> found = matchBoxes(detections, frame.truth);
      if (k == 0) targets = judge(detections, found, frame.truth, rows);
      for (std::size_t i = 0; i < detections.size(); ++i) {
        if (found[i] >= 0)
          addSighting(detections[i], frame.truth[static_cast<std::size_t>(found[i])], range, targets);
      }
    }
    for (const Target& target : targets) rows.push_back(rowOf(target));
    return rows;
  }

  /// A detection of someone who need not be found is neither right nor wrong.
  static std::vector<Target> judge(const std::vector<Detection>& detections, const std::vector<int>& found,
                                   const std::vector<PersonBox>& truth, Rows& rows) {
    std::vector<Target> targets;
    for (const PersonBox& box : truth) {
      if (mustBeFound(box)) targets.push_back({box, false, {}, {}, {}});
    }
    for (std::size_t i = 0; i < detections.size(); ++i) {
      const PersonBox* box = found[i] < 0 ? nullptr : &truth[static_cast<std::size_t>(found[i])];
      if (box != nullptr && !mustBeFound(*box)) continue;
      rows.push_back({{"kind", "detection"}, {"score", detections[i].score}, {"is_hit", box != nullptr}});
      for (Target& target : targets)
        target.was_found = target.was_found || (box != nullptr && target.truth.person == box->person);
    }
    return targets;
  }

  static void addSighting(const Detection& detection, const PersonBox& truth, const HeadRange& range,
                          std::vector<Target>& targets) {
    const HeadSighting sighting = range.locate(detection);
    for (Target& target : targets) {
      if (target.truth.person != truth.person || truth.visible < kWholeHead) continue;
      const HeadSighting from_truth = range.locate({0, "", 1.0, truth.box_px});
      if (from_truth.status == HeadSighting::Status::kGood)
        target.true_box_ratios.push_back(from_truth.range_m / truth.distance_m);
      target.height_ratios.push_back(detection.box.height / truth.box_px.height);
      if (sighting.status == HeadSighting::Status::kGood)
        target.range_ratios.push_back(sighting.range_m / truth.distance_m);
    }
  }

  static Json rowOf(const Target& target) {
    const auto ratio = mean(target.range_ratios);
    const auto true_box = mean(target.true_box_ratios);
    Json row = {{"kind", "target"},
                {"distance_m", target.truth.distance_m},
                {"visible", target.truth.visible},
                {"height_px", target.truth.box_px.height},
                {"was_found", target.was_found}};
    row["sightings"] = target.range_ratios.size();
    row["error_pct"] = ratio ? Json(100.0 * (*ratio - 1.0)) : Json();
    row["true_box_error_pct"] = true_box ? Json(100.0 * (*true_box - 1.0)) : Json();
    row["height_ratio"] = orNull(mean(target.height_ratios));
    return row;
  }

  std::string share_dir_;
  TrainingStock stock_;
  ParamTree model_;
  HeadRangeParams range_;
  Eigen::Isometry3d below_from_optical_ = Eigen::Isometry3d::Identity();
  double detect_ms_ = 0.0;
};

}  // namespace

std::unique_ptr<Suite> makeDetectorSuite() { return std::make_unique<DetectorSuite>(); }

}  // namespace frugal_nav::eval
