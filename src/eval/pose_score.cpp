#include "pose_score.hpp"

#include <cmath>

#include <Eigen/Cholesky>

namespace frugal_nav::eval {

void PoseScore::add(const Pose2& estimate, const Pose2& truth) {
  const double yaw_error = angleBetween(truth.yaw_rad, estimate.yaw_rad);
  position_ += (estimate.position() - truth.position()).squaredNorm();
  yaw_ += yaw_error * yaw_error;
  ++count_;
}

void PoseScore::add(const PoseEstimate& estimate, const Pose2& truth) {
  const Pose2& pose = estimate.map_from_base;
  add(pose, truth);
  const Eigen::Vector3d error(pose.x_m - truth.x_m, pose.y_m - truth.y_m,
                              angleBetween(truth.yaw_rad, pose.yaw_rad));
  normalised_ += error.dot(estimate.covariance.llt().solve(error)) / 3.0;
}

double PoseScore::positionRmse_m() const { return std::sqrt(meanOf(position_)); }
double PoseScore::yawRmse_deg() const { return std::sqrt(meanOf(yaw_)) * 180.0 / M_PI; }
double PoseScore::anees() const { return meanOf(normalised_); }

}  // namespace frugal_nav::eval
