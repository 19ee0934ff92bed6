#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <frugal_nav/common/time.hpp>

namespace frugal_nav::eval {

/// One pose of a trajectory.
struct TimedPose {
  Stamp stamp{};
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};
using Trajectory = std::vector<TimedPose>;

/// The poses of two trajectories at the same time.
struct PosePair {
  Eigen::Isometry3d reference = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d estimate = Eigen::Isometry3d::Identity();
};

/// Reads "stamp x y z qx qy qz qw" lines (the TUM RGB-D benchmark's format; # starts a comment). Throws
/// ConfigError naming the file and the line.
Trajectory readTumTrajectory(const std::string& path);

/// Pairs each pose of the shorter trajectory with the nearest in time of the other, as the public tool evo
/// does. Both must be in the order of time.
std::vector<PosePair> associate(const Trajectory& reference, const Trajectory& estimate, Duration max_apart);

/// reference = scale * rotation * estimate + translation.
struct Alignment {
  double scale = 1.0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return scale * (rotation * p) + translation; }
};

/// What of the estimate is free before it is compared.
enum class AlignmentKind { kNone, kRigid, kSimilarity };

/// Least-squares alignment of the positions (Umeyama, IEEE PAMI 13(4), 1991). nullopt with fewer than three
/// pairs, or when all positions coincide.
std::optional<Alignment> align(const std::vector<PosePair>& pairs, AlignmentKind kind);

/// Root mean square, mean and median of errors.
struct ErrorStatistics {
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;
};

/// Absolute trajectory error: distances of the positions after an alignment [m].
ErrorStatistics absoluteError(const std::vector<PosePair>& pairs, const Alignment& alignment);

/// Relative pose error over consecutive pairs, of the estimate as it is.
struct RelativeError {
  double translation_rmse_m = 0.0;
  double rotation_rmse_deg = 0.0;
};
RelativeError relativeError(const std::vector<PosePair>& pairs);

}  // namespace frugal_nav::eval
