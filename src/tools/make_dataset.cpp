// Renders labelled images of random scenes for scripts/train_depth and scripts/train_heads; see --help.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <mutex>
#include <thread>

#include <opencv2/imgcodecs.hpp>
#include <ros/package.h>
#include <unistd.h>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/eval/json.hpp>
#include <frugal_nav/eval/training_scene.hpp>
#include <frugal_nav/eval/view_truth.hpp>
#include <frugal_nav/sim/world_cache.hpp>

namespace {

namespace fs = std::filesystem;
using namespace frugal_nav;

const char* const kHelp = R"(usage: make_dataset [options]
  --out DIR         where to (default: $XDG_CACHE_HOME/frugal_nav/dataset)
  --first-seed N    seed of the first scene, from 1000000 (the default)
  --scenes N        how many scenes, one seed each (default 1600)
  --views N         cameras in each scene (default 4)
  --width PX        image width; the height is three quarters of it (default 416)
  --threads N       scenes rendered at once (default: one a processor)
  --worlds DIR      the package's folder of worlds and textures (default: the installed one)
Scenes whose labels are there are skipped; where only labels are missing, only they are made.
It writes for each view, named SEED_VIEW:
  images/*.jpg      what the camera gives, with its noise and exposure
  depth/*.png       16 bit, millimetres along the optical axis, 65535 for beyond 65 m, without noise
  labels/*.json     camera, light, and boxes: class (0 head, 1 person), centre, width and height as shares
                    of the image, share that is visible, distance
)";

struct Options {
  std::string out;
  std::string worlds;
  std::uint64_t first_seed = eval::kFirstTrainingSeed;
  int scenes = 1600;
  int views = 4;
  int width = 416;
  int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
};

long requireWhole(const std::string& option, const std::string& text, long least) {
  std::size_t used = 0;
  long number = least - 1;
  try {
    number = std::stol(text, &used);
  } catch (const std::exception&) {  // said below, like every other wrong text
  }
  if (used != text.size() || number < least)
    throw ConfigError(option + " takes a whole number from " + std::to_string(least) + ", not '" + text +
                      "'");
  return number;
}

Options parse(const std::vector<std::string>& arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); i += 2) {
    const std::string& name = arguments[i];
    if (i + 1 == arguments.size()) throw ConfigError(name + " needs a value; see make_dataset --help");
    const std::string& value = arguments[i + 1];
    const auto whole = [&](long least) { return static_cast<int>(requireWhole(name, value, least)); };
    if (name == "--out") {
      options.out = value;
    } else if (name == "--worlds") {
      options.worlds = value;
    } else if (name == "--first-seed") {
      options.first_seed = static_cast<std::uint64_t>(requireWhole(name, value, 0));
    } else if (name == "--scenes") {
      options.scenes = whole(1);
    } else if (name == "--views") {
      options.views = whole(1);
    } else if (name == "--width") {
      options.width = whole(64);
    } else if (name == "--threads") {
      options.threads = whole(1);
    } else {
      throw ConfigError("unknown option '" + name + "'; see make_dataset --help");
    }
  }
  if (options.out.empty()) {
    const std::string cache = sim::defaultCacheFolder();
    if (cache.empty()) throw ConfigError("neither XDG_CACHE_HOME nor HOME is set: give --out DIR");
    options.out = cache + "/dataset";
  }
  if (options.worlds.empty()) options.worlds = ros::package::getPath("frugal_nav") + "/worlds";
  return options;
}

/// The camera with the exposure that its automatic would settle at, a little off at times: measured by a tiny
/// image of the same view, so that one full image is enough.
sim::CameraParams expose(sim::CameraParams camera, const Eigen::Isometry3d& pose,
                         const sim::RayTracer& tracer, const sim::Lighting& lighting, Random& random) {
  constexpr int kMeterWidth_px = 48;
  constexpr int kMeterFrames = 5;
  sim::CameraParams meter_params = camera;
  meter_params.width_px = kMeterWidth_px;
  meter_params.height_px = 3 * kMeterWidth_px / 4;
  sim::Camera meter(meter_params, 0);
  for (int i = 0; i < kMeterFrames; ++i) meter.render(tracer, lighting, pose, pose, Stamp{});
  const double off = std::exp2(random.normal(0.3));
  camera.shortest_exposure_s = camera.longest_exposure_s =
      std::clamp(off * meter.exposureTime_s(), camera.shortest_exposure_s, camera.longest_exposure_s);
  camera.full_well_e /= meter.gain();  // a new camera's gain is one: the same full scale in electrons
  return camera;
}

cv::Mat toMillimetres(const cv::Mat& depth_m) {
  constexpr float kFarthest_mm = 65535.0F;
  cv::Mat depth_mm(depth_m.size(), CV_16UC1);
  for (int row = 0; row < depth_m.rows; ++row) {
    for (int column = 0; column < depth_m.cols; ++column) {
      const float mm = std::min(kFarthest_mm, 1000.0F * depth_m.at<float>(row, column));
      depth_mm.at<std::uint16_t>(row, column) = static_cast<std::uint16_t>(std::lround(mm));
    }
  }
  return depth_mm;
}

eval::Json describeView(std::uint64_t seed, const eval::TrainingView& view, const sim::Camera& camera,
                        double illuminance_lx, const std::vector<eval::PersonBox>& boxes) {
  const sim::CameraParams& params = camera.params();
  const cv::Matx33d k = camera.cameraMatrix();
  const cv::Vec<double, 5> d = camera.distortion();
  eval::Json label;
  label["seed"] = seed;
  label["size_px"] = {params.width_px, params.height_px};
  label["camera"] = {{"fx", k(0, 0)}, {"fy", k(1, 1)}, {"cx", k(0, 2)}, {"cy", k(1, 2)}};
  label["distortion"] = {d[0], d[1], d[2], d[3], d[4]};
  label["camera_height_m"] = view.camera_height_m;
  label["pitch_rad"] = view.pitch_rad;
  label["light"] = {{"setting", view.lighting.setting}, {"illuminance_lx", illuminance_lx}};
  label["boxes"] = eval::Json::array();
  for (const eval::PersonBox& box : boxes) {
    const cv::Rect2d& r = box.box_px;
    label["boxes"].push_back({{"class", box.is_head ? 0 : 1},
                              {"cx", (r.x + 0.5 * r.width) / params.width_px},
                              {"cy", (r.y + 0.5 * r.height) / params.height_px},
                              {"w", r.width / params.width_px},
                              {"h", r.height / params.height_px},
                              {"visible", box.visible},
                              {"distance_m", box.distance_m}});
  }
  return label;
}

void write(const std::string& path, const cv::Mat& image, const std::vector<int>& how) {
  if (!cv::imwrite(path, image, how)) throw std::runtime_error("cannot write " + path);
}

void renderScene(std::uint64_t seed, const eval::TrainingStock& stock, const Options& options) {
  const auto nameOf = [&](int view) { return std::to_string(seed) + "_" + std::to_string(view); };
  const fs::path out(options.out);
  const fs::path last = out / "labels" / (nameOf(options.views - 1) + ".json");
  if (fs::exists(last)) return;
  const eval::TrainingScene place = eval::makeTrainingScene(seed, stock);
  const sim::RayTracer tracer(place.scene);
  for (int v = 0; v < options.views; ++v) {
    Random random(seed, "training view " + std::to_string(v));
    const auto view = eval::drawTrainingView(place, tracer, options.width, random);
    if (!view) continue;
    const sim::Lighting lighting(view->lighting, tracer, seed + static_cast<std::uint64_t>(v));
    const Eigen::Isometry3d& pose = view->world_from_optical;
    const fs::path image_path = out / "images" / (nameOf(v) + ".jpg");
    const fs::path depth_path = out / "depth" / (nameOf(v) + ".png");
    const bool drawn = fs::exists(image_path) && fs::exists(depth_path);
    sim::Camera camera(drawn ? view->camera : expose(view->camera, pose, tracer, lighting, random),
                       seed + static_cast<std::uint64_t>(v));
    const cv::Size size(view->camera.width_px, view->camera.height_px);
    const eval::Viewpoint viewpoint{size, camera.cameraMatrix(), camera.distortion(), pose};
    const eval::ViewTruth truth = eval::traceTruth(tracer, viewpoint);
    const auto boxes = eval::findPeople(truth, place.scene, place.people, viewpoint);
    if (!drawn) {
      const cv::Mat image = camera.render(tracer, lighting, pose, pose, Stamp{}).bgr;
      write(image_path.string(), image, {cv::IMWRITE_JPEG_QUALITY, 95});
      write(depth_path.string(), toMillimetres(truth.depth_m), {cv::IMWRITE_PNG_COMPRESSION, 1});
    }
    std::ofstream label(out / "labels" / (nameOf(v) + ".json"));
    label << describeView(seed, *view, camera, lighting.illuminance_lx(), boxes) << "\n";
    if (!label) throw std::runtime_error("cannot write the label of " + nameOf(v));
  }
}

void drawProgress(int done, int total) {
  if (isatty(STDERR_FILENO) != 0 || done % 100 == 0 || done == total)
    std::fprintf(stderr, "\r%d of %d scenes%s", done, total, done == total ? "\n" : "");
}

void run(const Options& options) {
  if (options.first_seed < eval::kFirstTrainingSeed)
    eval::makeTrainingScene(options.first_seed, {});  // refuses, saying why, before anything is written
  for (const char* folder : {"images", "depth", "labels"})
    fs::create_directories(fs::path(options.out) / folder);
  const eval::TrainingStock stock = eval::readTrainingStock(options.worlds);
  std::atomic<int> next{0};
  std::atomic<int> done{0};
  std::mutex mutex;  // guards failure and the progress
  std::exception_ptr failure;
  const auto work = [&] {
    for (int i = next++; i < options.scenes; i = next++) {
      try {
        renderScene(options.first_seed + static_cast<std::uint64_t>(i), stock, options);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        if (!failure) failure = std::current_exception();
        next = options.scenes;
        return;
      }
      const std::lock_guard<std::mutex> lock(mutex);
      drawProgress(++done, options.scenes);
    }
  };
  std::vector<std::thread> workers;
  for (int i = 1; i < options.threads; ++i) workers.emplace_back(work);
  work();
  for (std::thread& worker : workers) worker.join();
  if (failure) std::rethrow_exception(failure);
  std::cout << "written: " << options.out << "\n";
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    if (std::count(arguments.begin(), arguments.end(), "--help") > 0) {
      std::cout << kHelp;
      return 0;
    }
    run(parse(arguments));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "make_dataset: " << error.what() << "\n";
    return 1;
  }
}
