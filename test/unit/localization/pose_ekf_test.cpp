#include <cmath>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <frugal_nav/common/random.hpp>
#include <frugal_nav/localization/pose_ekf.hpp>

namespace frugal_nav {
namespace {

EkfVector stateAt(double x, double y, double yaw) {
  EkfVector mean;
  mean << x, y, yaw, 0.03, 1.07, -0.02;
  return mean;
}

/// Central differences of a step by the state; the error is of the order of the increment squared, 1e-10.
EkfMatrix numericalByState(const EkfVector& mean, const EkfMotion& motion, double duration_s) {
  constexpr double kIncrement = 1e-5;
  EkfMatrix result;
  for (int i = 0; i < kEkfSize; ++i) {
    EkfVector more = mean;
    EkfVector less = mean;
    more[i] += kIncrement;
    less[i] -= kIncrement;
    EkfVector difference =
        stepAlongArc(more, motion, duration_s).mean - stepAlongArc(less, motion, duration_s).mean;
    difference[kEkfYaw] = wrapAngle(difference[kEkfYaw]);
    result.col(i) = difference / (2.0 * kIncrement);
  }
  return result;
}

TEST(PoseEkf, StepHasTheDerivativesByTheState) {
  for (const bool gyro : {false, true}) {
    const double bias = gyro ? 0.03 : -0.02;
    // The last but one turns by 0: the series; the last by little more than the series' limit.
    for (const double rate : {0.8, -2.5, bias, bias + 3e-3}) {
      const EkfMotion motion{0.06, 0.1 * rate, gyro};
      const EkfVector mean = stateAt(1.0, -2.0, 3.1);
      const EkfMatrix numerical = numericalByState(mean, motion, 0.1);
      EXPECT_LT((stepAlongArc(mean, motion, 0.1).by_state - numerical).cwiseAbs().maxCoeff(), 1e-8)
          << "rate " << rate << " gyro " << gyro;
    }
  }
}

TEST(PoseEkf, StepHasTheDerivativesByTheArc) {
  const EkfVector mean = stateAt(1.0, -2.0, 0.4);
  const EkfStep step = stepAlongArc(mean, {0.06, 0.08, true}, 0.1);
  constexpr double kIncrement = 1e-5;
  constexpr double kScale = 1.07;  // of stateAt: so much farther than told
  const EkfVector by_distance = (stepAlongArc(mean, {0.06 + kIncrement, 0.08, true}, 0.1).mean -
                                 stepAlongArc(mean, {0.06 - kIncrement, 0.08, true}, 0.1).mean) /
                                (2.0 * kIncrement * kScale);
  const EkfVector by_turn = (stepAlongArc(mean, {0.06, 0.08 + kIncrement, true}, 0.1).mean -
                             stepAlongArc(mean, {0.06, 0.08 - kIncrement, true}, 0.1).mean) /
                            (2.0 * kIncrement);
  EXPECT_LT((step.by_arc.col(0) - by_distance).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT((step.by_arc.col(1) - by_turn).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(PoseEkf, StepFollowsTheExactArc) {
  EkfVector mean = EkfVector::Zero();
  mean[kEkfScale] = 1.0;
  const EkfStep step = stepAlongArc(mean, {M_PI_2, M_PI_2, true}, M_PI_2);  // a quarter of a circle of 1 m
  EXPECT_NEAR(step.mean[kEkfX], 1.0, 1e-12);
  EXPECT_NEAR(step.mean[kEkfY], 1.0, 1e-12);
  EXPECT_NEAR(step.mean[kEkfYaw], M_PI_2, 1e-12);
}

TEST(PoseEkf, SightingHasTheDerivativesByTheState) {
  constexpr double kIncrement = 1e-5;
  const EkfVector mean = stateAt(1.0, -2.0, 2.0);
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(3.0, 1.0), Eigen::Vector2d(-4.0, -2.5)}) {
    const auto seen = predictSighting(mean, p);
    ASSERT_TRUE(seen);
    for (int i = 0; i < kEkfSize; ++i) {
      EkfVector more = mean;
      EkfVector less = mean;
      more[i] += kIncrement;
      less[i] -= kIncrement;
      Eigen::Vector2d difference =
          predictSighting(more, p)->range_bearing - predictSighting(less, p)->range_bearing;
      difference[1] = wrapAngle(difference[1]);
      EXPECT_LT((seen->by_state.col(i) - difference / (2.0 * kIncrement)).cwiseAbs().maxCoeff(), 1e-8);
    }
  }
  EXPECT_FALSE(predictSighting(mean, {1.0, -2.0}));
}

TEST(PoseEkf, GateIsTheChiSquareDistributions) {
  EXPECT_NEAR(chiSquareQuantile(0.95, 1), 3.841, 1e-3);  // from printed tables
  EXPECT_NEAR(chiSquareQuantile(0.99, 2), 9.210, 1e-3);
  EXPECT_NEAR(chiSquareQuantile(0.999, 3), 16.266, 1e-3);
  EXPECT_TRUE(std::isinf(chiSquareQuantile(1.0, 3)));
}

TEST(PoseEkf, RefusesParametersOutOfRange) {
  PoseFilterParams params;
  params.gate_probability = 1.5;
  EXPECT_THROW(PoseEkf{params}, ConfigError);
  params = PoseFilterParams();
  params.twist_source = "wish";
  EXPECT_THROW(PoseEkf{params}, ConfigError);
}

/// A drive whose noise is drawn from the densities that the filter is told.
class SimulatedDrive {
 public:
  SimulatedDrive(const PoseFilterParams& params, std::uint64_t seed) : params_(params), random_(seed) {
    gyro_bias_ = random_.normal(params.gyro_bias_sigma_radps);
    scale_ = 1.0 + (params.estimate_scale ? random_.normal(params.scale_sigma) : 0.0);
    rate_bias_ = params.estimate_rate_bias ? random_.normal(params.rate_bias_sigma_radps) : 0.0;
  }

  /// One step with a constant twist; the truth's noise is the filter's model, so that it must be consistent.
  void step(const Twist2& twist, double duration_s) {
    const TwistNoiseParams& noise = params_.twist;
    const double distance = std::abs(twist.v_mps) * duration_s;
    const double told = scale_ * twist.v_mps * duration_s;
    const double root = std::sqrt(duration_s);
    const double length = told + random_.normal(noise.distance_noise * std::sqrt(distance)) +
                          random_.normal(noise.speed_noise * root);
    const double turn = (twist.w_radps - rate_bias_) * duration_s +
                        random_.normal(noise.turn_noise * std::sqrt(std::abs(twist.w_radps) * duration_s)) +
                        random_.normal(noise.veer_noise * std::sqrt(distance)) +
                        random_.normal(noise.rate_noise * root);
    pose = pose * arcMotion({length / duration_s, turn / duration_s}, duration_s);
    gyro_radps = turn / duration_s + gyro_bias_ + random_.normal(params_.gyro_noise / root);
    gyro_bias_ += random_.normal(params_.gyro_bias_walk * root);
    if (params_.estimate_scale) scale_ += random_.normal(params_.scale_walk * root);
    if (params_.estimate_rate_bias) rate_bias_ += random_.normal(params_.rate_bias_walk * root);
  }

  PoseFix fix(const Eigen::Vector3d& sigmas) {
    PoseFix result;
    result.map_from_base = {pose.x_m + random_.normal(sigmas[0]), pose.y_m + random_.normal(sigmas[1]),
                            wrapAngle(pose.yaw_rad + random_.normal(sigmas[2]))};
    result.covariance = sigmas.cwiseAbs2().asDiagonal();
    return result;
  }

  LandmarkSighting sighting(const Eigen::Vector2d& p_map) {
    LandmarkSighting seen;
    seen.p_map = p_map;
    seen.range_m = (p_map - pose.position()).norm() + random_.normal(0.05);
    seen.bearing_rad = wrapAngle(bearingTo(pose, p_map) + random_.normal(0.02));
    seen.covariance.diagonal() << 0.05 * 0.05, 0.02 * 0.02;
    return seen;
  }

  Pose2 pose;
  double gyro_radps = 0.0;

 private:
  PoseFilterParams params_;
  Random random_;
  double gyro_bias_ = 0.0;
  double scale_ = 1.0;
  double rate_bias_ = 0.0;
};

double squaredError(const EkfState& state, const Pose2& truth) {
  Eigen::Vector3d error = state.mean.head<3>() - Eigen::Vector3d(truth.x_m, truth.y_m, truth.yaw_rad);
  error[2] = wrapAngle(error[2]);
  const Eigen::Matrix3d covariance = state.covariance.topLeftCorner<3, 3>();
  return error.dot(covariance.llt().solve(error));
}

struct DriveKind {
  bool gyro = true;
  bool optional_states = false;
  bool sightings = false;
};

/// Normalised squared error over its degrees of freedom at the end of a drive of 20 s with a measurement a
/// second.
double consistencyOf(const DriveKind& kind, std::uint64_t seed) {
  PoseFilterParams params;
  params.twist_source = "command";  // holds from its stamp on, as the drive does it
  params.gate_probability = 1.0;    // the gate cuts the tails off
  params.estimate_scale = params.estimate_rate_bias = kind.optional_states;
  const PoseEkf ekf(params);
  SimulatedDrive drive(params, seed);
  constexpr double kStep_s = 0.02;
  EkfState state = ekf.withPose(ekf.initial(Stamp{}), Stamp{}, drive.fix({0.03, 0.03, 0.02})).state;
  for (int i = 1; i <= 1000; ++i) {
    const Twist2 twist{0.3, 0.5 * std::sin(0.01 * i)};
    state = ekf.withTwist(state, state.stamp, twist);
    drive.step(twist, kStep_s);
    const Stamp now = state.stamp + fromSeconds(kStep_s);
    if (kind.gyro) {  // the rate is the step's mean: handed over at its start, to hold until its end
      state.gyro_radps = HeldInput<double>{state.stamp, drive.gyro_radps};
    }
    state = ekf.predicted(state, now);
    if (i % 50 != 25) continue;
    if (kind.sightings) {
      state = ekf.withSighting(state, now, drive.sighting({4.0, i % 100 == 25 ? 3.0 : -3.0})).state;
    } else {
      state = ekf.withPose(state, now, drive.fix({0.05, 0.03, 0.02})).state;
    }
  }
  return squaredError(state, drive.pose) / 3.0;
}

/// The mean of n runs' chi-square of 3 degrees, divided by 3, has the deviation sqrt(2 / (3 n)): with 200
/// runs 0.058. Five of it bound what is right; half or twice the covariance lies far outside.
TEST(PoseEkf, IsConsistentOnDrives) {
  for (const DriveKind& kind :
       {DriveKind{true, false, false}, DriveKind{false, false, false}, DriveKind{true, true, false},
        DriveKind{false, true, false}, DriveKind{true, false, true}, DriveKind{false, true, true}}) {
    double sum = 0.0;
    for (std::uint64_t seed = 500000; seed < 500200; ++seed) sum += consistencyOf(kind, seed);
    EXPECT_NEAR(sum / 200.0, 1.0, 0.29)
        << "gyro " << kind.gyro << " states " << kind.optional_states << " sightings " << kind.sightings;
  }
}

TEST(PoseEkf, ALongGapIsCrossedInAHundredStepsOrSo) {
  const PoseEkf ekf{PoseFilterParams{}};
  PoseFix fix;
  fix.covariance.diagonal().setConstant(1e-4);
  const EkfState state = ekf.withPose(ekf.initial(Stamp{}), Stamp{}, fix).state;
  // Steps of 0.1 s would be six hundred million.
  const EkfState after = ekf.predicted(state, Stamp{} + std::chrono::hours(24 * 365 * 2));
  EXPECT_TRUE(after.covariance.allFinite());
}

TEST(PoseEkf, RepeatedUpdatesKeepTheCovariancePositive) {
  const PoseEkf ekf{PoseFilterParams{}};
  PoseFix fix;
  fix.covariance = Eigen::Vector3d(1e-12, 1e-12, 1e-12).asDiagonal();
  EkfState state = ekf.withPose(ekf.initial(Stamp{}), Stamp{}, fix).state;
  for (int i = 1; i <= 2000; ++i) {
    state = ekf.withTwist(state, stampFromSeconds(0.02 * i), {0.0, 0.0});
    state = ekf.withGyro(state, stampFromSeconds(0.02 * i), 0.0);
    state = ekf.withPose(state, stampFromSeconds(0.02 * i), fix).state;
    const Eigen::Matrix4d estimated = state.covariance.topLeftCorner<4, 4>();
    ASSERT_EQ(estimated.llt().info(), Eigen::Success) << i;
    ASSERT_EQ(state.covariance, state.covariance.transpose()) << i;
  }
}

}  // namespace
}  // namespace frugal_nav
