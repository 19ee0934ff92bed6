#include "rgbd_depth.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <frugal_nav/eval/statistics.hpp>
#include <frugal_nav/odometry/visual_odometry.hpp>
#include <frugal_nav/perception/depth_correction.hpp>
#include <frugal_nav/perception/metric_fit.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kFramePeriod_s = 0.1;  // the recording has no stamps
constexpr double kMillimetre = 0.001;

std::vector<std::string> filesOf(const std::string& folder) {
  if (!std::filesystem::is_directory(folder))
    throw ConfigError("there is no folder " + folder +
                      ": give a recording with images, depth, K.txt, poses.txt");
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<double> numbersOf(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw ConfigError("file " + path + " cannot be opened: it belongs to the recording");
  std::vector<double> numbers;
  for (double number = 0.0; file >> number;) numbers.push_back(number);
  return numbers;
}

/// Mean relative error over the pixels of known depth.
std::optional<double> relativeError(const cv::Mat& depth_m, const cv::Mat& truth_m) {
  double sum = 0.0;
  int count = 0;
  for (int row = 0; row < truth_m.rows; ++row) {
    for (int column = 0; column < truth_m.cols; ++column) {
      const float truth = truth_m.at<float>(row, column);
      const float depth = depth_m.at<float>(row, column);
      if (!(truth > 0.0F) || !std::isfinite(depth)) continue;
      sum += static_cast<double>(std::abs(depth - truth) / truth);
      ++count;
    }
  }
  return count > 0 ? std::optional<double>(sum / count) : std::nullopt;
}

double medianWhereKnown(const cv::Mat& map, const cv::Mat& truth_m) {
  std::vector<float> values;
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.cols; ++column) {
      if (truth_m.at<float>(row, column) > 0.0F) values.push_back(map.at<float>(row, column));
    }
  }
  if (values.empty()) return 0.0;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return static_cast<double>(values[values.size() / 2]);
}

/// A point's place in the grid and its depth.
struct Known {
  cv::Point2f cell;
  double depth_m;
  double sigma_m;
};

std::vector<Known> knownDepths(const VisualOdometryOutput& output, const cv::Size& image,
                               const cv::Size& grid, double scale_sigma) {
  std::vector<Known> known;
  if (!output.is_metric) return known;
  for (const VisualPoint& point : output.points) {
    const double depth = point.p_camera.z();
    const double sigma = std::hypot(point.sigma_m, scale_sigma * depth);
    if (!(depth > 0.0) || !(sigma < 0.5 * depth)) continue;
    const cv::Point2f cell(static_cast<float>((point.pixel.x() + 0.5) * grid.width / image.width - 0.5),
                           static_cast<float>((point.pixel.y() + 0.5) * grid.height / image.height - 0.5));
    known.push_back({cell, depth, sigma});
  }
  return known;
}

/// Fits and mends a network's answer with the points of visual odometry, as DepthGap does without a floor.
class PointFusion {
 public:
  explicit PointFusion(const DepthGapParams& params) : params_(params), filter_(params.fit) {}

  /// Depth [m] of the inverse map's size; empty without a scale.
  cv::Mat fuse(Stamp stamp, const cv::Mat& inverse, const std::vector<Known>& known) {
    std::vector<MetricSample> samples;
    std::vector<DepthAnchor> anchors;
    const cv::Rect all(cv::Point(), inverse.size());
    for (const Known& k : known) {
      const cv::Point cell(cvRound(k.cell.x), cvRound(k.cell.y));
      if (!all.contains(cell)) continue;
      samples.push_back({static_cast<double>(inverse.at<float>(cell)), 1.0 / k.depth_m,
                         k.sigma_m / (k.depth_m * k.depth_m), Cue::kVo});
      anchors.push_back({k.cell, 1.0 / k.depth_m, k.sigma_m / k.depth_m});
    }
    const MetricFit& fit = filter_.update(stamp, samples);
    if (!fit.known || anchors.empty()) return {};
    constexpr double kLeast_pm = 0.05;
    const cv::Mat fitted = cv::max(cv::Mat(fit.a * inverse + fit.b), kLeast_pm);
    return 1.0 / correctDepth(fitted, anchors, params_.correction);
  }

 private:
  DepthGapParams params_;
  MetricFilter filter_;
};

}  // namespace

RgbdRecording readRgbdRecording(const std::string& folder) {
  RgbdRecording recording;
  recording.images = filesOf(folder + "/images");
  recording.depths = filesOf(folder + "/depth");
  const std::vector<double> poses = numbersOf(folder + "/poses.txt");
  const std::vector<double> k = numbersOf(folder + "/K.txt");
  const std::size_t count = recording.images.size();
  if (count == 0 || recording.depths.size() != count || poses.size() != 16 * count || k.size() != 9) {
    throw ConfigError("recording " + folder + ": " + std::to_string(count) + " images, " +
                      std::to_string(recording.depths.size()) + " depth images, " +
                      std::to_string(poses.size() / 16) + " poses and " + std::to_string(k.size()) +
                      " numbers of K do not fit together");
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> pose(poses.data() + 16 * i);
    recording.world_from_camera.emplace_back(Eigen::Matrix4d(pose));
  }
  const cv::Mat first = cv::imread(recording.images.front());
  recording.camera = {first.cols, first.rows, k[0], k[4], k[2], k[5], 0.0, 0.0, 0.0, 0.0, 0.0};
  return recording;
}

Rows measureRgbd(const RgbdRecording& recording, DepthNetwork& network, const DepthGapParams& params) {
  VisualOdometryParams vo_params;
  vo_params.motion.wheels = "scale";  // the poses' turns and courses are not used
  vo_params.motion.planar = false;
  VisualOdometry odometry(vo_params, recording.camera, Eigen::Isometry3d::Identity());
  PointFusion fusion(params);
  Rows rows;
  for (std::size_t i = 0; i < recording.images.size(); ++i) {
    const Stamp stamp = stampFromSeconds(1.0 + kFramePeriod_s * static_cast<double>(i));
    const cv::Mat bgr = cv::imread(recording.images[i]);
    cv::Mat truth_m;
    cv::imread(recording.depths[i], cv::IMREAD_UNCHANGED).convertTo(truth_m, CV_32F, kMillimetre);
    const VisualOdometryOutput visual = odometry.process({stamp, bgr, recording.world_from_camera[i], {}});
    const cv::Mat inverse = network.infer(bgr).inverse;
    const auto atFullSize = [&](const cv::Mat& depth) {
      cv::Mat full;
      cv::resize(depth, full, truth_m.size(), 0.0, 0.0, cv::INTER_LINEAR);
      return full;
    };
    const cv::Mat alone = atFullSize(1.0 / cv::max(inverse, 1e-3));
    const double ratio = medianWhereKnown(truth_m, truth_m) / medianWhereKnown(alone, truth_m);
    const cv::Mat fused =
        fusion.fuse(stamp, inverse, knownDepths(visual, bgr.size(), inverse.size(), params.vo_scale_sigma));
    Json row;
    row["trial"] = 0;  // a recording is one
    row["frame"] = i;
    row["rel_network"] = orNull(relativeError(alone, truth_m));
    row["rel_median"] = orNull(relativeError(ratio * alone, truth_m));
    row["rel_fused"] = fused.empty() ? Json() : orNull(relativeError(atFullSize(fused), truth_m));
    row["vo_points"] = visual.points.size();
    row["vo_state"] = text(visual.status.state);
    const Eigen::Vector3d truth = recording.world_from_camera[i].translation();
    const Eigen::Vector3d estimate = visual.odom_from_camera.translation();
    row["true_m"] = {truth.x(), truth.y(), truth.z()};
    row["vo_m"] = {estimate.x(), estimate.y(), estimate.z()};
    rows.push_back(row);
  }
  return rows;
}

}  // namespace frugal_nav::eval
