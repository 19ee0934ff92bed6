#include <algorithm>

#include <frugal_nav/odometry/visual_stray_watch.hpp>

namespace frugal_nav {
namespace {

// Over a checkpoint's way: what slip, a wrong wheel radius or separation may make. Beyond it the images
// erred.
constexpr double kStray_m = 0.05;
constexpr double kStrayShare = 0.1;
constexpr double kStray_rad = 0.08;
constexpr double kStrayTurnShare = 0.15;
constexpr double kCheckpointWay_m = 0.5;
constexpr double kCheckpointTurn_rad = 1.0;
constexpr double kDeniedWindow_m = 0.1;  // way over which seen and told motion are compared
constexpr double kDeniedShare = 0.5;     // seen over told below which the motion is denied
constexpr double kDenied_m = 0.25;  // longer than the window, so that wheels that begin to slip are not it
constexpr std::size_t kMostRecent = 30;

}  // namespace

VisualStrayWatch::VisualStrayWatch(const VisualCheckParams& checks, double focal_px)
    : checks_(checks), focal_px_(focal_px) {}

void VisualStrayWatch::reset() {
  checkpoint_.reset();
  recent_.clear();
}

std::optional<Eigen::Isometry3d> VisualStrayWatch::check(const Eigen::Isometry3d& odom_from_camera,
                                                         const Eigen::Isometry3d& wheels_from_camera,
                                                         const Eigen::Isometry3d& step, const RayMap& rays) {
  const double step_m = step.translation().norm();
  const bool denies = deniesMotion(odom_from_camera, rays, step_m);
  if (!checkpoint_) {
    checkpoint_ = Checkpoint{odom_from_camera, wheels_from_camera};
    return std::nullopt;
  }
  checkpoint_->way_m += step_m;
  checkpoint_->turn_rad += turnOf(step);
  checkpoint_->denied_m = denies ? checkpoint_->denied_m + step_m : 0.0;
  const Eigen::Isometry3d told = checkpoint_->wheels_from_camera.inverse() * wheels_from_camera;
  const Eigen::Isometry3d seen = checkpoint_->odom_from_camera.inverse() * odom_from_camera;
  // Wheels that slip or spin turn more than the robot moves, never less: of less the images may tell.
  const double length2 = told.translation().squaredNorm();
  const double share = length2 > 0.0 ? seen.translation().dot(told.translation()) / length2 : 0.0;
  const Eigen::Vector3d beside = seen.translation() - std::clamp(share, 0.0, 1.0) * told.translation();
  const bool strays = beside.norm() > kStray_m + kStrayShare * checkpoint_->way_m ||
                      turnOf(seen) > turnOf(told) + kStray_rad + kStrayTurnShare * checkpoint_->turn_rad ||
                      checkpoint_->denied_m > kDenied_m;
  const bool is_old = checkpoint_->way_m > kCheckpointWay_m || checkpoint_->turn_rad > kCheckpointTurn_rad;
  if (strays) return checkpoint_->odom_from_camera * told;
  if (is_old && !denies) checkpoint_ = Checkpoint{odom_from_camera, wheels_from_camera};
  return std::nullopt;
}

/// Whether over the last piece of way the pose stood nearly still, the wheels turned, and the images show
/// that the camera moved: a map that has shrunk, as a turn on the spot can leave it.
bool VisualStrayWatch::deniesMotion(const Eigen::Isometry3d& odom_from_camera, const RayMap& rays,
                                    double step_m) {
  recent_.push_back({odom_from_camera, rays, step_m});
  double way_m = 0.0;
  for (std::size_t i = 1; i < recent_.size(); ++i) way_m += recent_[i].step_m;
  while (recent_.size() > 2 &&
         (way_m - recent_[1].step_m >= kDeniedWindow_m || recent_.size() > kMostRecent)) {
    way_m -= recent_[1].step_m;
    recent_.pop_front();
  }
  if (way_m < kDeniedWindow_m) return false;
  const Past& before = recent_.front();
  const double seen_m = (odom_from_camera.translation() - before.odom_from_camera.translation()).norm();
  return seen_m < kDeniedShare * way_m && showsTranslation(before.rays, rays);
}

/// Whether features have moved otherwise than a turn moves them. Too few of them tell nothing: then yes.
bool VisualStrayWatch::showsTranslation(const RayMap& before, const RayMap& now) const {
  const SharedRays shared = sharedBetween(before, now);
  const auto turn = fitRotation(shared.before, shared.now, focal_px_, checks_.rotation_residual_px);
  return !turn || static_cast<int>(shared.ids.size()) < checks_.min_features ||
         turn->median_residual_px > checks_.rotation_residual_px;
}

}  // namespace frugal_nav
