#include "point_world.hpp"

#include <gtest/gtest.h>

namespace frugal_nav {
namespace {

/// Drives the base through a room and compares the estimate with the truth.
class Drive {
 public:
  explicit Drive(const VisualOdometryParams& params = {}, std::uint64_t seed = 500001)
      : world_(seed), estimator_(params, testCamera().fx, cameraMount()) {}

  /// One image after a motion of the base. The wheels report `slip` times the truth.
  VisualUpdate step(const Twist2& twist, double slip = 1.0, bool has_wheels = true) {
    constexpr double kPeriod_s = 0.1;
    truth_ = truth_ * arcMotion(twist, kPeriod_s);
    wheels_ = wheels_ * arcMotion({slip * twist.v_mps, twist.w_radps}, kPeriod_s);
    way_m_ += std::abs(twist.v_mps) * kPeriod_s;
    std::optional<Eigen::Isometry3d> wheels;
    if (has_wheels) wheels = toIsometry(wheels_) * cameraMount();
    last_ = estimator_.update(world_.see(toIsometry(truth_) * cameraMount(), 0.3), wheels);
    ++count_[last_.state];
    return last_;
  }
  void run(const Twist2& twist, int steps, double slip = 1.0, bool has_wheels = true) {
    for (int i = 0; i < steps; ++i) step(twist, slip, has_wheels);
  }

  Pose2 estimate() const {
    const Eigen::Isometry3d pose = estimator_.odomFromCamera() * cameraMount().inverse();
    return {pose.translation().x(), pose.translation().y(), std::atan2(pose.linear()(1, 0), pose.linear()(0, 0))};
  }
  double error_m() const { return distance(estimate(), truth_); }
  double way_m() const { return way_m_; }
  const Pose2& truth() const { return truth_; }
  int count(VisualState state) { return count_[state]; }
  VisualEstimator& estimator() { return estimator_; }
  PointWorld& world() { return world_; }
  const VisualUpdate& last() const { return last_; }

 private:
  PointWorld world_;
  VisualEstimator estimator_;
  Pose2 truth_{-3.0, -1.0, 0.2};
  Pose2 wheels_{-3.0, -1.0, 0.2};
  double way_m_ = 0.0;
  std::map<VisualState, int> count_;
  VisualUpdate last_;
};

TEST(VisualEstimator, FollowsStraightTurnStraight) {
  Drive drive;
  drive.run({0.3, 0.0}, 80);
  drive.run({0.0, -0.6}, 26);
  drive.run({0.3, 0.0}, 60);
  std::printf("error %.4f m of %.2f m, yaw %.4f rad, tracking %d rotating %d init %d lost %d\n", drive.error_m(),
              drive.way_m(), angleBetween(drive.truth().yaw_rad, drive.estimate().yaw_rad),
              drive.count(VisualState::kTracking), drive.count(VisualState::kRotating),
              drive.count(VisualState::kInitializing), drive.count(VisualState::kLost));
  EXPECT_LT(drive.error_m(), 0.02 * drive.way_m());
  EXPECT_GE(drive.count(VisualState::kTracking), 150);
}

}  // namespace
}  // namespace frugal_nav
