#pragma once

#include <optional>

#include <Eigen/Core>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/localization/pose_filter_params.hpp>

/// The extended Kalman filter's equations: pure functions of a state. PoseFilter keeps their history.
namespace frugal_nav {

/// Places in the state's vector. A state that is not estimated has no variance and so never changes.
enum EkfIndex : int { kEkfX, kEkfY, kEkfYaw, kEkfGyroBias, kEkfScale, kEkfRateBias, kEkfSize };

using EkfVector = Eigen::Matrix<double, kEkfSize, 1>;
using EkfMatrix = Eigen::Matrix<double, kEkfSize, kEkfSize>;

/// What moves the state now.
enum class MotionSource { kNone, kTwistOnly, kGyroOnly, kTwistAndGyro };

/// A held input and since when it holds.
template <class Value>
struct HeldInput {
  Stamp stamp{};
  Value value{};
};

/// Poses refused since the last one used, which agree with each other.
struct GatedRow {
  int count = 0;
  Stamp since{};
  Pose2 refused_from_believed;  ///< of the first: from the pose it was refused for to its own, in the map
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the first
  Eigen::Matrix3d believed = Eigen::Matrix3d::Zero();    ///< the state's then
};

/// The filter at one instant: (x, y, yaw) of the base in the map, gyro bias [rad/s], true over told speed,
/// and the offset of the twist's yaw rate [rad/s].
struct EkfState {
  Stamp stamp{};
  EkfVector mean = EkfVector::Zero();
  EkfMatrix covariance = EkfMatrix::Zero();
  bool has_fix = false;  ///< before, the pose means nothing; the biases do
  std::optional<GatedRow> gated;
  std::optional<HeldInput<Twist2>> twist;
  std::optional<HeldInput<double>> gyro_radps;
  std::optional<Stamp> still_since;  ///< of the wheels
};

/// A pose of the base in the map that something measured.
struct PoseFix {
  Pose2 map_from_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, yaw)
};

/// A known point of the map, seen from the base.
struct LandmarkSighting {
  Eigen::Vector2d p_map = Eigen::Vector2d::Zero();
  double range_m = 0.0;
  double bearing_rad = 0.0;                              ///< left positive
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (range, bearing)
};

/// What moves the state in one step, as wheels and gyro tell it.
struct EkfMotion {
  double distance_m = 0.0;
  double turn_rad = 0.0;
  bool turn_is_gyro = false;  ///< which of the two rate offsets is taken off
};

/// A step along the exact arc with its derivatives.
struct EkfStep {
  EkfVector mean;
  EkfMatrix by_state;
  Eigen::Matrix<double, kEkfSize, 2> by_arc;  ///< by the step's (distance, turn)
};
EkfStep stepAlongArc(const EkfVector& mean, const EkfMotion& motion, double duration_s);

/// (range, bearing) of a point of the map as the state predicts them, with derivatives. nullopt when the base
/// stands on the point.
struct SightingPrediction {
  Eigen::Vector2d range_bearing;
  Eigen::Matrix<double, 2, kEkfSize> by_state;
};
std::optional<SightingPrediction> predictSighting(const EkfVector& mean, const Eigen::Vector2d& p_map);

/// The chi-square distribution's quantile for 1 to 3 degrees of freedom; infinite for probability 1.
double chiSquareQuantile(double probability, int degrees);

/// The equations with their parameters.
class PoseEkf {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit PoseEkf(const PoseFilterParams& params);

  /// Without a fix, biases as they are at switch-on.
  EkfState initial(Stamp stamp) const;
  /// The state moved on to a later instant with the inputs it holds. An input past its time-out is not
  /// believed; without a twist the position becomes uncertain every way, without either the heading too.
  EkfState predicted(EkfState state, Stamp stamp) const;

  /// A new twist or yaw rate at its stamp. What encoders say is the mean since their last twist, what the
  /// gyro says has changed evenly since its last rate, what was commanded holds from its stamp on. While the
  /// wheels stand, the yaw rate is the gyro's bias.
  EkfState withTwist(EkfState state, Stamp stamp, const Twist2& twist) const;
  EkfState withGyro(EkfState state, Stamp stamp, double rate_radps) const;

  /// A measurement at its stamp. `used` false: refused by the gate, the state only moved on. The first pose
  /// is the fix; a sighting needs one.
  struct Corrected {
    EkfState state;
    bool used = false;
    bool restarted = false;  ///< too many that agree were refused: the pose is the measured one
  };
  Corrected withPose(EkfState state, Stamp stamp, const PoseFix& fix) const;
  Corrected withSighting(EkfState state, Stamp stamp, const LandmarkSighting& sighting) const;

  /// The state with its pose replaced; the biases stay, no longer correlated with it.
  static EkfState relocated(EkfState state, const PoseFix& fix);

  MotionSource motionSource(const EkfState& state) const;
  const PoseFilterParams& params() const { return params_; }

 private:
  bool hasTwist(const EkfState& state) const;
  bool hasGyro(const EkfState& state) const;
  bool isStill(const EkfState& state) const;
  template <class Value>
  double heldFor_s(const std::optional<HeldInput<Value>>& input, Stamp stamp) const;
  void noteGated(const PoseFix& fix, EkfState& state) const;
  Duration stepLength(const EkfState& state, Stamp stamp, Duration longest) const;
  EkfState stepped(EkfState state, Duration step) const;
  void addNoise(const EkfState& before, const EkfStep& step, double duration_s, EkfMatrix& covariance) const;

  PoseFilterParams params_;
  double pose_gate_ = 0.0;
  double sighting_gate_ = 0.0;
};

}  // namespace frugal_nav
