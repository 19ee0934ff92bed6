#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include <frugal_nav/localization/pose_ekf.hpp>

namespace frugal_nav {
namespace {

/// Longest step of the linearised covariance; a gap is crossed in about kMaxSteps all the same.
constexpr double kLongestStep_s = 0.1;
constexpr int kMaxSteps = 100;

/// A Kalman update in Joseph's form, which keeps the covariance symmetric and positive (Bucy and Joseph,
/// 1968). False, with the state untouched, when the innovation lies beyond the gate.
template <int kRows>
bool correct(const Eigen::Matrix<double, kRows, 1>& innovation,
             const Eigen::Matrix<double, kRows, kEkfSize>& by_state,
             const Eigen::Matrix<double, kRows, kRows>& noise, double gate, EkfState& state) {
  using Square = Eigen::Matrix<double, kRows, kRows>;
  const Eigen::Matrix<double, kEkfSize, kRows> cross = state.covariance * by_state.transpose();
  const Square spread = by_state * cross + noise;
  const Eigen::LLT<Square> factor(spread);
  if (factor.info() != Eigen::Success) return false;
  if (!(innovation.dot(factor.solve(innovation)) <= gate)) return false;

  const Eigen::Matrix<double, kEkfSize, kRows> gain = factor.solve(cross.transpose()).transpose();
  state.mean += gain * innovation;
  state.mean[kEkfYaw] = wrapAngle(state.mean[kEkfYaw]);
  const EkfMatrix kept = EkfMatrix::Identity() - gain * by_state;
  const EkfMatrix covariance = kept * state.covariance * kept.transpose() + gain * noise * gain.transpose();
  state.covariance = 0.5 * (covariance + covariance.transpose());
  return true;
}

double square(double x) { return x * x; }

Pose2 believedPose(const EkfState& state) {
  return {state.mean[kEkfX], state.mean[kEkfY], state.mean[kEkfYaw]};
}

Eigen::Vector3d difference(const Pose2& from, const Pose2& to) {
  return {to.x_m - from.x_m, to.y_m - from.y_m, angleBetween(from.yaw_rad, to.yaw_rad)};
}

/// Moves on by what an input that was held told too little or too much: its noise is in the step already.
void makeUp(const EkfMotion& motion, EkfState& state) {
  const EkfStep step = stepAlongArc(state.mean, motion, 0.0);
  state.mean = step.mean;
  state.covariance = step.by_state * state.covariance * step.by_state.transpose();
}

/// The chi-square distribution function for 1 to 3 degrees of freedom.
double chiSquareShare(double x, int degrees) {
  if (degrees == 2) return 1.0 - std::exp(-0.5 * x);
  const double one = std::erf(std::sqrt(0.5 * x));
  return degrees == 1 ? one : one - std::sqrt(2.0 * x / M_PI) * std::exp(-0.5 * x);
}

}  // namespace

double chiSquareQuantile(double probability, int degrees) {
  if (probability >= 1.0) return std::numeric_limits<double>::infinity();
  double low = 0.0;
  double high = 100.0;  // beyond it the shares are 1 to all digits
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (chiSquareShare(middle, degrees) < probability ? low : high) = middle;
  }
  return high;
}

EkfStep stepAlongArc(const EkfVector& mean, const EkfMotion& motion, double duration_s) {
  const EkfIndex bias = motion.turn_is_gyro ? kEkfGyroBias : kEkfRateBias;
  const double length = mean[kEkfScale] * motion.distance_m;
  const double turn = motion.turn_rad - mean[bias] * duration_s;
  const double half = 0.5 * turn;
  // Chord over arc, sin(h)/h, and its derivative by h; series near zero, where the quotients lose digits.
  const bool straight = std::abs(half) < 1e-4;
  const double ratio = straight ? 1.0 - half * half / 6.0 : std::sin(half) / half;
  const double ratio_by_half = straight ? -half / 3.0 : (std::cos(half) - ratio) / half;
  const double c = std::cos(mean[kEkfYaw] + half);
  const double s = std::sin(mean[kEkfYaw] + half);

  EkfStep step;
  step.mean = mean;
  step.mean[kEkfX] += length * ratio * c;
  step.mean[kEkfY] += length * ratio * s;
  step.mean[kEkfYaw] = wrapAngle(mean[kEkfYaw] + turn);

  step.by_arc.setZero();
  step.by_arc.topRows<3>() << ratio * c, 0.5 * length * (ratio_by_half * c - ratio * s),  //
      ratio * s, 0.5 * length * (ratio_by_half * s + ratio * c),                          //
      0.0, 1.0;
  step.by_state.setIdentity();
  step.by_state(kEkfX, kEkfYaw) = -length * ratio * s;
  step.by_state(kEkfY, kEkfYaw) = length * ratio * c;
  step.by_state.block<3, 1>(0, kEkfScale) = motion.distance_m * step.by_arc.block<3, 1>(0, 0);
  step.by_state.block<3, 1>(0, bias) = -duration_s * step.by_arc.block<3, 1>(0, 1);
  return step;
}

std::optional<SightingPrediction> predictSighting(const EkfVector& mean, const Eigen::Vector2d& p_map) {
  const double dx = p_map.x() - mean[kEkfX];
  const double dy = p_map.y() - mean[kEkfY];
  const double range = std::hypot(dx, dy);
  if (range < 1e-6) return std::nullopt;
  SightingPrediction predicted;
  predicted.range_bearing << range, wrapAngle(std::atan2(dy, dx) - mean[kEkfYaw]);
  predicted.by_state.setZero();
  predicted.by_state.leftCols<3>() << -dx / range, -dy / range, 0.0,  //
      dy / square(range), -dx / square(range), -1.0;
  return predicted;
}

PoseEkf::PoseEkf(const PoseFilterParams& params) : params_(params) {
  validate(params_, "pose filter");
  pose_gate_ = chiSquareQuantile(params_.gate_probability, 3);
  sighting_gate_ = chiSquareQuantile(params_.gate_probability, 2);
}

EkfState PoseEkf::initial(Stamp stamp) const {
  EkfState state;
  state.stamp = stamp;
  state.mean[kEkfScale] = 1.0;
  state.covariance(kEkfGyroBias, kEkfGyroBias) = square(params_.gyro_bias_sigma_radps);
  if (params_.estimate_scale) state.covariance(kEkfScale, kEkfScale) = square(params_.scale_sigma);
  if (params_.estimate_rate_bias)
    state.covariance(kEkfRateBias, kEkfRateBias) = square(params_.rate_bias_sigma_radps);
  return state;
}

EkfState PoseEkf::predicted(EkfState state, Stamp stamp) const {
  const Duration longest = std::max(fromSeconds(kLongestStep_s), (stamp - state.stamp) / kMaxSteps);
  while (state.stamp < stamp) state = stepped(state, stepLength(state, stamp, longest));
  return state;
}

EkfState PoseEkf::withTwist(EkfState state, Stamp stamp, const Twist2& twist) const {
  state = predicted(state, stamp);
  const bool still =
      std::abs(twist.v_mps) <= params_.still_speed_mps && std::abs(twist.w_radps) <= params_.still_rate_radps;
  const double since_s = heldFor_s(state.twist, stamp);
  const bool stood = isStill(state) && still;
  if (params_.twist_source == "encoders" && since_s > 0.0 && !stood) {
    const Twist2& held = state.twist->value;
    const double turn = hasGyro(state) ? 0.0 : (twist.w_radps - held.w_radps) * since_s;
    makeUp({(twist.v_mps - held.v_mps) * since_s, turn, false}, state);
  }
  if (!still || !hasTwist(state)) state.still_since.reset();
  if (still && !state.still_since) state.still_since = stamp;
  state.twist = HeldInput<Twist2>{stamp, twist};
  return state;
}

EkfState PoseEkf::withGyro(EkfState state, Stamp stamp, double rate_radps) const {
  state = predicted(state, stamp);
  const double since_s = heldFor_s(state.gyro_radps, stamp);
  const double grown = since_s > 0.0 ? rate_radps - state.gyro_radps->value : 0.0;
  state.gyro_radps = HeldInput<double>{stamp, rate_radps};
  if (!isStill(state)) {
    makeUp({0.0, 0.5 * grown * since_s, true}, state);
  } else if (since_s > 0.0) {
    Eigen::Matrix<double, 1, kEkfSize> by_state = Eigen::Matrix<double, 1, kEkfSize>::Zero();
    by_state[kEkfGyroBias] = 1.0;
    const Eigen::Matrix<double, 1, 1> innovation(rate_radps - state.mean[kEkfGyroBias]);
    const Eigen::Matrix<double, 1, 1> noise(square(params_.gyro_noise) / since_s);
    correct<1>(innovation, by_state, noise, std::numeric_limits<double>::infinity(), state);
  }
  return state;
}

PoseEkf::Corrected PoseEkf::withPose(EkfState state, Stamp stamp, const PoseFix& fix) const {
  Corrected result{predicted(state, stamp), true, false};
  if (!result.state.has_fix) {
    result.state = relocated(result.state, fix);
    return result;
  }
  const Eigen::Vector3d innovation = difference(believedPose(result.state), fix.map_from_base);
  Eigen::Matrix<double, 3, kEkfSize> by_state = Eigen::Matrix<double, 3, kEkfSize>::Identity();
  result.used = correct<3>(innovation, by_state, fix.covariance, pose_gate_, result.state);
  if (result.used) {
    result.state.gated.reset();
    return result;
  }
  noteGated(fix, result.state);
  const GatedRow& row = *result.state.gated;
  if (params_.restart_after_gated > 0 && row.count >= params_.restart_after_gated &&
      stamp - row.since >= fromSeconds(params_.restart_after_s)) {
    result = {relocated(result.state, fix), true, true};
  }
  return result;
}

/// A refused pose goes on the row when it lies where the motion since then leads from the row's first.
void PoseEkf::noteGated(const PoseFix& fix, EkfState& state) const {
  constexpr double kAgreement = 0.1;  // m, rad: what one marker's place in the map may differ from another's
  const Pose2 believed = believedPose(state);
  const Eigen::Matrix3d covariance = state.covariance.topLeftCorner<3, 3>();
  if (state.gated) {
    const GatedRow& row = *state.gated;
    const Eigen::Vector3d off = difference(row.refused_from_believed * believed, fix.map_from_base);
    Eigen::Matrix3d spread = row.covariance + fix.covariance;
    spread.diagonal() += (covariance - row.believed).diagonal().cwiseMax(0.0);  // the motion's since then
    spread.diagonal().array() += square(kAgreement);
    if (off.dot(spread.llt().solve(off)) > pose_gate_) state.gated.reset();
  }
  if (!state.gated)
    state.gated =
        GatedRow{0, state.stamp, fix.map_from_base * believed.inverse(), fix.covariance, covariance};
  ++state.gated->count;
}

PoseEkf::Corrected PoseEkf::withSighting(EkfState state, Stamp stamp,
                                         const LandmarkSighting& sighting) const {
  Corrected result{predicted(state, stamp), false, false};
  const auto expected = predictSighting(result.state.mean, sighting.p_map);
  if (!result.state.has_fix || !expected) return result;
  Eigen::Vector2d innovation(sighting.range_m, sighting.bearing_rad);
  innovation -= expected->range_bearing;
  innovation[1] = wrapAngle(innovation[1]);
  result.used = correct<2>(innovation, expected->by_state, sighting.covariance, sighting_gate_, result.state);
  return result;
}

EkfState PoseEkf::relocated(EkfState state, const PoseFix& fix) {
  const Pose2& pose = fix.map_from_base;
  state.mean.head<3>() << pose.x_m, pose.y_m, wrapAngle(pose.yaw_rad);
  state.covariance.topRows<3>().setZero();
  state.covariance.leftCols<3>().setZero();
  state.covariance.topLeftCorner<3, 3>() = fix.covariance;
  state.has_fix = true;
  state.gated.reset();
  return state;
}

MotionSource PoseEkf::motionSource(const EkfState& state) const {
  if (hasTwist(state)) return hasGyro(state) ? MotionSource::kTwistAndGyro : MotionSource::kTwistOnly;
  return hasGyro(state) ? MotionSource::kGyroOnly : MotionSource::kNone;
}

bool PoseEkf::hasTwist(const EkfState& state) const {
  return state.twist && state.stamp < state.twist->stamp + fromSeconds(params_.input_timeout_s);
}

bool PoseEkf::hasGyro(const EkfState& state) const {
  return state.gyro_radps && state.stamp < state.gyro_radps->stamp + fromSeconds(params_.input_timeout_s);
}

bool PoseEkf::isStill(const EkfState& state) const {
  if (!hasTwist(state) || !state.still_since) return false;
  if (state.stamp - *state.still_since < fromSeconds(params_.still_time_s)) return false;
  return !hasGyro(state) ||
         std::abs(state.gyro_radps->value - state.mean[kEkfGyroBias]) <= params_.still_gyro_radps;
}

/// How long an input has been held; 0 when it is not there, or was not believed to the end.
template <class Value>
double PoseEkf::heldFor_s(const std::optional<HeldInput<Value>>& input, Stamp stamp) const {
  const bool is_believed = input && stamp <= input->stamp + fromSeconds(params_.input_timeout_s);
  return is_believed ? toSeconds(stamp - input->stamp) : 0.0;
}

Duration PoseEkf::stepLength(const EkfState& state, Stamp stamp, Duration longest) const {
  Duration step = std::min(stamp - state.stamp, longest);
  // A step ends where an input ceases to be believed.
  const Duration timeout = fromSeconds(params_.input_timeout_s);
  if (hasTwist(state)) step = std::min(step, state.twist->stamp + timeout - state.stamp);
  if (hasGyro(state)) step = std::min(step, state.gyro_radps->stamp + timeout - state.stamp);
  return step;
}

EkfState PoseEkf::stepped(EkfState state, Duration duration) const {
  const double duration_s = toSeconds(duration);
  EkfMotion motion;
  if (hasTwist(state))
    motion = {state.twist->value.v_mps * duration_s, state.twist->value.w_radps * duration_s, false};
  if (hasGyro(state)) {
    motion.turn_rad = state.gyro_radps->value * duration_s;
    motion.turn_is_gyro = true;
  }
  const bool still = isStill(state);
  // Standing, and without either input, no offset may turn the heading.
  const bool turns = !still && (hasTwist(state) || hasGyro(state));
  if (!turns) motion = {0.0, state.mean[kEkfRateBias] * duration_s, false};
  EkfStep step = stepAlongArc(state.mean, motion, duration_s);
  if (!turns) step.by_state.setIdentity();

  EkfMatrix covariance = step.by_state * state.covariance * step.by_state.transpose();
  if (still) {
    covariance.diagonal().head<3>().array() += square(params_.still_noise) * duration_s;
  } else {
    addNoise(state, step, duration_s, covariance);
  }
  covariance(kEkfGyroBias, kEkfGyroBias) += square(params_.gyro_bias_walk) * duration_s;
  if (params_.estimate_scale) covariance(kEkfScale, kEkfScale) += square(params_.scale_walk) * duration_s;
  if (params_.estimate_rate_bias)
    covariance(kEkfRateBias, kEkfRateBias) += square(params_.rate_bias_walk) * duration_s;
  state.mean = step.mean;
  state.covariance = covariance;
  state.stamp += duration;
  return state;
}

void PoseEkf::addNoise(const EkfState& before, const EkfStep& step, double duration_s,
                       EkfMatrix& covariance) const {
  const TwistNoiseParams& noise = params_.twist;
  double distance_variance = 0.0;
  double turn_variance = square(params_.lost_turn_noise) * duration_s;
  if (hasTwist(before)) {
    const double distance = std::abs(before.twist->value.v_mps) * duration_s;
    const double turn = std::abs(before.twist->value.w_radps) * duration_s;
    distance_variance = square(noise.distance_noise) * distance + square(noise.speed_noise) * duration_s;
    turn_variance = square(noise.turn_noise) * turn + square(noise.veer_noise) * distance +
                    square(noise.rate_noise) * duration_s;
  } else {
    const double lost = square(params_.lost_speed_noise) * duration_s;
    covariance(kEkfX, kEkfX) += lost;
    covariance(kEkfY, kEkfY) += lost;
  }
  if (hasGyro(before)) turn_variance = square(params_.gyro_noise) * duration_s;
  const Eigen::Vector2d variances(distance_variance, turn_variance);
  covariance += step.by_arc * variances.asDiagonal() * step.by_arc.transpose();
}

}  // namespace frugal_nav
