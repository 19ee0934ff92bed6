#pragma once

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/localization/pose_filter.hpp>

namespace frugal_nav::eval {

/// How far estimates of a pose are from the truth, over many instants.
class PoseScore {
 public:
  void add(const Pose2& estimate, const Pose2& truth);
  /// With its covariance, for anees(); a score is of poses with or of poses without.
  void add(const PoseEstimate& estimate, const Pose2& truth);

  int count() const { return count_; }
  // Of no estimates all three are 0.
  double positionRmse_m() const;
  double yawRmse_deg() const;
  /// Squared error over what the covariance says, by 3, on average: 1 is consistent (Bar-Shalom, Li and
  /// Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001, section 5.4).
  double anees() const;

 private:
  double meanOf(double sum) const { return count_ > 0 ? sum / count_ : 0.0; }

  double position_ = 0.0;  // sums of squares
  double yaw_ = 0.0;
  double normalised_ = 0.0;
  int count_ = 0;
};

}  // namespace frugal_nav::eval
