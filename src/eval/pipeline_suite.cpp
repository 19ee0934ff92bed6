#include "pipeline_suite.hpp"

#include "random_paint.hpp"

#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <stdexcept>
#include <vector>

#include <opencv2/core/utility.hpp>
#include <opencv2/dnn/dnn.hpp>

#include <frugal_nav/eval/camera_layout.hpp>
#include <frugal_nav/eval/camera_stack.hpp>
#include <frugal_nav/eval/midas_sized_network.hpp>
#include <frugal_nav/eval/statistics.hpp>
#include <frugal_nav/eval/stopwatch.hpp>
#include <frugal_nav/eval/visual_drive.hpp>
#include <frugal_nav/perception/network.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kRobotWidth_m = 0.25;
// The first images find everything cold: caches, goal, visual odometry.
constexpr int kWarmUp = 10;

struct PipelineOptions {
  int frames = 60;
  int width = 640;
  int threads_a_frame = 2;
  double pss_mb = 0.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("frames", frames, Field{"", "images of a trial that are measured", 1, 10000});
    visit("width", width, Field{"px", "columns of the images, three quarters as many rows", 160, 1280});
    visit("threads_a_frame", threads_a_frame, Field{"", "threads that OpenCV may use for one image", 1, 64});
    visit("pss_mb", pss_mb,
          Field{"MB", "memory of the nodes, as scripts/measure_nodes --hybrid prints it; 0: not measured",
                0.0, 1e6});
  }
};

/// A network and an image's worth of input for it.
class TimedNetwork {
 public:
  TimedNetwork(const std::string& file, int width_px, int height_px)
      : network_(file),
        blob_(cv::dnn::blobFromImage(cv::Mat(height_px, width_px, CV_8UC3, cv::Scalar::all(100)),
                                     1.0 / 255.0)) {}
  /// Time of one run [ms].
  double run() {
    const double begin_ms = wallTime_ms();
    network_.run(blob_);
    return wallTime_ms() - begin_ms;
  }

 private:
  Network network_;
  cv::Mat blob_;
};

/// A file that is gone with this object.
class TemporaryFile {
 public:
  TemporaryFile() {
    std::string folder = (std::filesystem::temp_directory_path() / "frugal_nav.XXXXXX").string();
    if (mkdtemp(folder.data()) == nullptr) throw ConfigError("no temporary folder at " + folder);
    folder_ = folder;
  }
  ~TemporaryFile() {
    std::error_code error;
    std::filesystem::remove_all(folder_, error);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  std::string path() const { return (folder_ / "network.onnx").string(); }

 private:
  std::filesystem::path folder_;
};

class PipelineSuite : public SuiteWithOptions<PipelineOptions> {
 public:
  std::string help() const override {
    return "time a frame of the camera pipeline by stage, beside a depth network of MiDaS v2.1 small's size";
  }
  int defaultTrials() const override { return 3; }

  void prepare(const RunContext& context) override {
    robot_ = loadRobot(context.share_dir + "/urdf/frugal_bot.urdf");
    params_ = loadCameraStack(context.share_dir);
    textures_ = readTextures(context.share_dir + "/worlds/textures");
    cv::setNumThreads(options_.threads_a_frame);
    const TemporaryFile file;
    writeMidasSizedNetwork(file.path());
    constexpr int kMidasSide_px = 256;
    midas_ = std::make_unique<TimedNetwork>(file.path(), kMidasSide_px, kMidasSide_px);
    const auto in_models = [&](const std::string& name) {
      return (std::filesystem::path(params_.models_dir) / name).string();
    };
    depth_ = std::make_unique<TimedNetwork>(in_models(params_.network.model), params_.network.input_width_px,
                                            params_.network.input_height_px);
    detector_ = std::make_unique<TimedNetwork>(
        in_models(params_.detector.model), params_.detector.input_width_px, params_.detector.input_height_px);
  }

  Rows runTrial(const Trial& trial) const override {
    // What is measured must have the processor for itself.
    const std::lock_guard<std::mutex> lock(alone_);
    constexpr double kSpeed_mps = 0.25;
    constexpr double kRate_hz = 5.0;
    CameraStackParams params = params_;
    adapt(params, kSpeed_mps, kRate_hz);
    const CameraLayout layout = makeCameraLayout(trial.seed, kRobotWidth_m, textures_);
    sim::SimulatorParams simulator_params;
    simulator_params.sensors = {true, false, false, true, false};
    simulator_params.camera.width_px = options_.width;
    simulator_params.camera.height_px = 3 * options_.width / 4;
    simulator_params.camera.rate_hz = kRate_hz;
    simulator_params.lighting.setting = layout.light;
    sim::Simulator simulator(layout.scene, robot_, simulator_params, trial.seed, layout.start);
    CameraStack stack(params, robot_, pinholeOf(simulator.camera()), Duration::zero());
    std::map<std::string, std::vector<double>> times;
    for (int frame = 0; frame < kWarmUp + options_.frames;) {
      const sim::SimOutput output = simulator.step();
      if (output.image) stack.addImage(output.image->stamp, output.image->bgr);
      if (output.ticks) {
        simulator.setCommand(stack.addTicks(output.stamp, output.ticks->left, output.ticks->right).velocity);
      }
      if (!output.image || !stack.last() || stack.last()->stamp != output.image->stamp) continue;
      if (++frame > kWarmUp) addFrame(stack.times(), times);
    }
    Json row;
    row["trial"] = trial.index;
    row["light"] = layout.light;
    for (const auto& [stage, values] : times) row[stage] = orNull(mean(values));
    return {row};
  }

  Json summarise(const Rows& rows) const override {
    std::map<std::string, std::vector<double>> values;
    for (const Json& row : rows) {
      for (const auto& item : row.items()) {
        if (item.value().is_number()) values[item.key()].push_back(item.value().get<double>());
      }
    }
    Json summary;
    for (const char* key : {"network_ms", "rest_ms", "detector_ms", "shipped_network_ms",
                            "visual_odometry_ms", "depth_rest_ms", "detector_rest_ms", "plan_ms", "frame_ms"})
      summary[key] = orNull(mean(values[key]));
    summary["pss_mb"] = options_.pss_mb > 0.0 ? Json(options_.pss_mb) : Json();
    const auto known = [&](const char* key) { return mean(values[key]).value_or(0.0); };
    if (rows.empty()) return summary;
    summary["rest_over_network"] = known("rest_ms") / known("network_ms");
    summary["frames_per_s"] = 1000.0 / known("frame_ms");
    summary["frames_per_s_midas"] = 1000.0 / (known("rest_ms") + known("detector_ms") + known("network_ms"));
    return summary;
  }

 private:
  /// The networks are timed again, alone, so that what is wrapped around them counts as the rest.
  void addFrame(const CameraStageTimes& stage, std::map<std::string, std::vector<double>>& times) const {
    double detector_ms = 0.0;
    for (int i = 0; i < stage.detector_runs; ++i) detector_ms += detector_->run();
    const double shipped_ms = depth_->run();
    const double frame_ms = stage.detector_ms + stage.visual_ms + stage.depth_ms + stage.plan_ms;
    times["frame_ms"].push_back(frame_ms);
    times["detector_ms"].push_back(detector_ms);
    times["detector_rest_ms"].push_back(stage.detector_ms - detector_ms);
    times["shipped_network_ms"].push_back(shipped_ms);
    times["depth_rest_ms"].push_back(stage.depth_ms - shipped_ms);
    times["visual_odometry_ms"].push_back(stage.visual_ms);
    times["plan_ms"].push_back(stage.plan_ms);
    times["rest_ms"].push_back(frame_ms - detector_ms - shipped_ms);
    times["network_ms"].push_back(midas_->run());
  }

  RobotModel robot_;
  CameraStackParams params_;
  std::vector<sim::Texture> textures_;
  mutable std::mutex alone_;
  std::unique_ptr<TimedNetwork> midas_;
  std::unique_ptr<TimedNetwork> depth_;
  std::unique_ptr<TimedNetwork> detector_;
};

}  // namespace

std::unique_ptr<Suite> makePipelineSuite() { return std::make_unique<PipelineSuite>(); }

}  // namespace frugal_nav::eval
