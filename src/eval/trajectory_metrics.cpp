#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include <Eigen/SVD>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/eval/trajectory_metrics.hpp>

namespace frugal_nav::eval {
namespace {

/// A stamp as the double that its decimal text reads as.
double asDouble(Stamp stamp) {
  return static_cast<double>(static_cast<long double>(stamp.time_since_epoch().count()) / 1e9L);
}

/// Nearest pose in time; the earlier one of two that are equally near. In doubles, which round today's stamps
/// to 240 ns, because the public tool's ties are decided so.
const TimedPose& nearest(const Trajectory& trajectory, Stamp stamp) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), stamp,
                                      [](const TimedPose& pose, Stamp s) { return pose.stamp < s; });
  if (after == trajectory.begin()) return *after;
  const auto before = after - 1;
  if (after == trajectory.end()) return *before;
  const double to_before = asDouble(stamp) - asDouble(before->stamp);
  return to_before <= asDouble(after->stamp) - asDouble(stamp) ? *before : *after;
}

/// A decimal number of seconds, exact to the nanosecond: a double at today's stamps is good to 240 ns only.
/// nullopt for any other text.
std::optional<Stamp> parseStamp(const std::string& text) {
  constexpr std::size_t kFractionDigits = 9;
  const std::size_t point = std::min(text.find('.'), text.size());
  std::string fraction = point < text.size() ? text.substr(point + 1) : "";
  fraction.resize(kFractionDigits, '0');
  const std::string digits = text.substr(0, point) + fraction;
  constexpr std::size_t kMostDigits = 19;  // with which a stamp of 1970 to 2262 fits 64 bits
  if (point == 0 || digits.size() > kMostDigits ||
      (digits.size() == kMostDigits && digits > "9223372036854775807") ||
      digits.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  return Stamp(std::chrono::nanoseconds(std::stoll(digits)));
}

}  // namespace

Trajectory readTumTrajectory(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw ConfigError("cannot read the trajectory " + path);
  Trajectory trajectory;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream in(line);
    std::string stamp_text;
    Eigen::Vector3d p;
    Eigen::Quaterniond q;
    in >> stamp_text >> p.x() >> p.y() >> p.z() >> q.x() >> q.y() >> q.z() >> q.w();
    const std::optional<Stamp> stamp = parseStamp(stamp_text);
    if (!in || !stamp || !(q.norm() > 0.0))
      throw ConfigError(path + ": line " + std::to_string(number) + " is not 'stamp x y z qx qy qz qw'");
    TimedPose pose;
    pose.stamp = *stamp;
    pose.pose.linear() = q.normalized().toRotationMatrix();
    pose.pose.translation() = p;
    trajectory.push_back(pose);
  }
  return trajectory;
}

std::vector<PosePair> associate(const Trajectory& reference, const Trajectory& estimate, Duration max_apart) {
  std::vector<PosePair> pairs;
  if (reference.empty() || estimate.empty()) return pairs;
  const bool estimate_is_longer = estimate.size() > reference.size();
  for (const TimedPose& pose : estimate_is_longer ? reference : estimate) {
    const TimedPose& other = nearest(estimate_is_longer ? estimate : reference, pose.stamp);
    if (std::chrono::abs(other.stamp - pose.stamp) > max_apart) continue;
    pairs.push_back(estimate_is_longer ? PosePair{pose.pose, other.pose} : PosePair{other.pose, pose.pose});
  }
  return pairs;
}

std::optional<Alignment> align(const std::vector<PosePair>& pairs, AlignmentKind kind) {
  if (kind == AlignmentKind::kNone) return Alignment{};
  if (pairs.size() < 3) return std::nullopt;
  const auto count = static_cast<double>(pairs.size());
  Eigen::Vector3d reference_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d estimate_mean = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) {
    reference_mean += pair.reference.translation() / count;
    estimate_mean += pair.estimate.translation() / count;
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double variance = 0.0;
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d estimate = pair.estimate.translation() - estimate_mean;
    covariance += (pair.reference.translation() - reference_mean) * estimate.transpose() / count;
    variance += estimate.squaredNorm() / count;
  }
  if (!(variance > 0.0)) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d sign(1.0, 1.0,
                             svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1.0 : 1.0);
  Alignment out;
  out.rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  if (kind == AlignmentKind::kSimilarity) out.scale = svd.singularValues().dot(sign) / variance;
  out.translation = reference_mean - out.scale * (out.rotation * estimate_mean);
  return out;
}

ErrorStatistics absoluteError(const std::vector<PosePair>& pairs, const Alignment& alignment) {
  ErrorStatistics out;
  if (pairs.empty()) return out;
  std::vector<double> errors;
  for (const PosePair& pair : pairs)
    errors.push_back((alignment * pair.estimate.translation() - pair.reference.translation()).norm());
  std::sort(errors.begin(), errors.end());
  for (const double error : errors) {
    out.mean += error / static_cast<double>(errors.size());
    out.rmse += error * error / static_cast<double>(errors.size());
  }
  out.rmse = std::sqrt(out.rmse);
  const std::size_t half = errors.size() / 2;
  out.median = errors.size() % 2 == 1 ? errors[half] : 0.5 * (errors[half - 1] + errors[half]);
  return out;
}

RelativeError relativeError(const std::vector<PosePair>& pairs) {
  RelativeError out;
  if (pairs.size() < 2) return out;
  const auto count = static_cast<double>(pairs.size() - 1);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const Eigen::Isometry3d reference = pairs[i - 1].reference.inverse() * pairs[i].reference;
    const Eigen::Isometry3d estimate = pairs[i - 1].estimate.inverse() * pairs[i].estimate;
    const Eigen::Isometry3d error = reference.inverse() * estimate;
    const double angle_deg = Eigen::AngleAxisd(error.linear()).angle() * 180.0 / M_PI;
    out.translation_rmse_m += error.translation().squaredNorm() / count;
    out.rotation_rmse_deg += angle_deg * angle_deg / count;
  }
  out.translation_rmse_m = std::sqrt(out.translation_rmse_m);
  out.rotation_rmse_deg = std::sqrt(out.rotation_rmse_deg);
  return out;
}

}  // namespace frugal_nav::eval
