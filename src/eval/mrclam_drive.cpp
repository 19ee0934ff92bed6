#include "mrclam_drive.hpp"

#include "pose_score.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>

namespace frugal_nav::eval {
namespace {

/// Truth farther apart is no truth in between: Vicon lost the robot.
constexpr double kLongestTruthGap_s = 0.2;

using Table = std::vector<std::vector<double>>;

Table readTable(const std::string& path, std::size_t columns) {
  std::ifstream file(path);
  if (!file)
    throw ConfigError(path + ": cannot be read; --mrclam names a folder of the UTIAS data set, unpacked");
  Table table;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    std::istringstream text(line);
    std::vector<double> row{std::istream_iterator<double>(text), {}};
    if (row.size() != columns || !text.eof()) {
      throw ConfigError(path + ":" + std::to_string(number) + ": not " + std::to_string(columns) +
                        " numbers");
    }
    table.push_back(std::move(row));
  }
  return table;
}

std::vector<MrclamLine> readLines(const std::string& path, std::size_t columns) {
  std::vector<MrclamLine> lines;
  for (const std::vector<double>& row : readTable(path, columns)) {
    lines.push_back({stampFromSeconds(row[0]), {row.begin() + 1, row.end()}});
  }
  std::stable_sort(lines.begin(), lines.end(),
                   [](const MrclamLine& a, const MrclamLine& b) { return a.stamp < b.stamp; });
  return lines;
}

/// Where the landmark of each barcode stands.
std::map<int, std::pair<double, double>> readLandmarks(const std::string& folder) {
  std::map<int, std::pair<double, double>> by_subject;
  for (const auto& row : readTable(folder + "/Landmark_Groundtruth.dat", 5)) {
    by_subject[static_cast<int>(row[0])] = {row[1], row[2]};
  }
  std::map<int, std::pair<double, double>> by_barcode;
  for (const auto& row : readTable(folder + "/Barcodes.dat", 2)) {
    const auto landmark = by_subject.find(static_cast<int>(row[0]));
    if (landmark != by_subject.end()) by_barcode[static_cast<int>(row[1])] = landmark->second;
  }
  return by_barcode;
}

class TruthReader {
 public:
  explicit TruthReader(const std::vector<MrclamLine>& truth) : truth_(truth) {}

  /// The pose at an instant, between the two readings around it.
  std::optional<Pose2> at(Stamp stamp) const {
    const auto after = std::lower_bound(truth_.begin(), truth_.end(), stamp,
                                        [](const MrclamLine& line, Stamp at) { return line.stamp < at; });
    if (after == truth_.end() || after == truth_.begin()) return std::nullopt;
    const MrclamLine& before = *std::prev(after);
    const double gap_s = toSeconds(after->stamp - before.stamp);
    if (gap_s > kLongestTruthGap_s) return std::nullopt;
    return interpolate(poseOf(before), poseOf(*after), toSeconds(stamp - before.stamp) / gap_s);
  }

 private:
  static Pose2 poseOf(const MrclamLine& line) { return {line.values[0], line.values[1], line.values[2]}; }

  const std::vector<MrclamLine>& truth_;
};

LandmarkSighting sightingOf(const MrclamLine& line, const MrclamParams& params) {
  LandmarkSighting sighting;
  sighting.p_map = {line.values[0], line.values[1]};
  sighting.range_m = line.values[2];
  sighting.bearing_rad = line.values[3];
  const double range_sigma = std::hypot(params.range_sigma_m, params.range_sigma_share * line.values[2]);
  sighting.covariance.diagonal() << range_sigma * range_sigma,
      params.bearing_sigma_rad * params.bearing_sigma_rad;
  return sighting;
}

}  // namespace

MrclamParams::MrclamParams() {
  filter.twist_source = "command";  // the data set's odometry is what was commanded
  filter.input_timeout_s = 2.0;     // it pauses for up to a second while the command holds
  filter.estimate_scale = true;
  filter.scale_walk = 1e-4;
  filter.estimate_rate_bias = true;
  filter.rate_bias_sigma_radps = 0.1;
  filter.rate_bias_walk = 1e-4;
  filter.twist = {0.08, 0.01, 0.15, 0.01, 0.001};
}

std::vector<MrclamRun> readMrclam(const std::string& folder) {
  const auto landmarks = readLandmarks(folder);
  std::vector<MrclamRun> runs;
  for (int number = 1; number <= 5; ++number) {
    MrclamRun run;
    run.robot = "Robot" + std::to_string(number);
    const std::string prefix = folder + "/" + run.robot;
    if (!std::filesystem::exists(prefix + "_Odometry.dat")) continue;
    run.odometry = readLines(prefix + "_Odometry.dat", 3);
    run.truth = readLines(prefix + "_Groundtruth.dat", 4);
    for (const MrclamLine& line : readLines(prefix + "_Measurement.dat", 4)) {
      const auto landmark = landmarks.find(static_cast<int>(line.values[0]));
      if (landmark == landmarks.end()) continue;  // another robot
      const auto& [x, y] = landmark->second;
      run.measurements.push_back({line.stamp, {x, y, line.values[1], line.values[2]}});
    }
    runs.push_back(std::move(run));
  }
  if (runs.empty()) throw ConfigError(folder + ": no Robot1_Odometry.dat to Robot5_Odometry.dat in it");
  return runs;
}

MrclamScore scoreMrclam(const MrclamRun& run, const MrclamParams& params) {
  const TruthReader truth(run.truth);
  PoseFilter filter(params.filter);
  PoseScore errors;
  auto sighting = run.measurements.begin();
  for (const MrclamLine& line : run.odometry) {
    for (; sighting != run.measurements.end() && sighting->stamp <= line.stamp; ++sighting) {
      filter.addSighting(sighting->stamp, sightingOf(*sighting, params), sighting->stamp);
    }
    filter.addCommand(line.stamp, {line.values[0], line.values[1]}, line.stamp);
    const std::optional<Pose2> pose = truth.at(line.stamp);
    if (!pose) continue;
    if (!filter.estimate()) {
      const Eigen::Vector3d sigmas(0.01, 0.01, 0.01);
      filter.setPose(line.stamp, {*pose, sigmas.cwiseAbs2().asDiagonal()}, line.stamp);
    }
    errors.add(*filter.estimate(), *pose);
  }
  if (errors.count() == 0) throw ConfigError(run.robot + ": no truth at any odometry stamp");

  const auto gated = static_cast<double>(filter.counts().of(FilterInput::kSighting, FilterStatus::kGated));
  const auto used = static_cast<double>(filter.counts().of(FilterInput::kSighting, FilterStatus::kUsed));
  MrclamScore score;
  score.position_rmse_m = errors.positionRmse_m();
  score.yaw_rmse_deg = errors.yawRmse_deg();
  score.anees = errors.anees();
  score.gated_share = gated + used > 0.0 ? gated / (gated + used) : 0.0;
  return score;
}

}  // namespace frugal_nav::eval
