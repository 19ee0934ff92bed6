#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <variant>

#include <frugal_nav/localization/pose_ekf.hpp>

namespace frugal_nav {

/// What the filter takes.
enum class FilterInput { kEncoders, kCommand, kGyro, kPose, kSighting };
constexpr std::size_t kFilterInputs = 5;

/// What became of a measurement.
enum class FilterStatus {
  kUsed,
  kGated,          ///< improbable by the chi-square gate
  kNoFix,          ///< a sighting before the first pose
  kNotFinite,      ///< NaN or infinite
  kBadCovariance,  ///< not symmetric and positive definite
  kFromFuture,     ///< stamped later than it was received
  kTooOld,         ///< older than the history
  kDisabled,       ///< switched off, or the twist that is not the twist source
};
constexpr std::size_t kFilterStatuses = 8;

/// The names for diagnostics.
const char* toText(FilterInput input);
const char* toText(FilterStatus status);
const char* toText(MotionSource source);

/// What the filter has met.
struct PoseFilterCounts {
  /// By input and status. A measurement counts once, as it was judged when it came.
  std::array<std::array<std::uint64_t, kFilterStatuses>, kFilterInputs> measurements{};
  std::uint64_t late = 0;        ///< came after a later one: replayed
  std::uint64_t time_jumps = 0;  ///< back: started anew
  std::uint64_t restarts = 0;    ///< from a measured pose after too many were refused in a row

  std::uint64_t of(FilterInput input, FilterStatus status) const {
    return measurements[static_cast<std::size_t>(input)][static_cast<std::size_t>(status)];
  }
};

/// The pose of the base in the map at one instant.
struct PoseEstimate {
  Stamp stamp{};
  Pose2 map_from_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, yaw)
  double gyro_bias_radps = 0.0;
  double scale = 1.0;            ///< true over told speed
  double rate_bias_radps = 0.0;  ///< of the twist
  MotionSource source = MotionSource::kNone;
};

/// Pose in the map from wheels, gyro and measured poses or sightings of landmarks, each at its own stamp.
///
/// The measurements of the last history_s are kept with the state after each; one that comes late is put in
/// its place and those after it are replayed, so that the order of arrival makes no difference. `received` is
/// the time (ROS time) at which a measurement came in: stamps beyond it are refused, and when it goes back by
/// more than jump_back_s time has jumped and everything is forgotten.
class PoseFilter {
 public:
  /// Throws ConfigError on parameters out of range.
  explicit PoseFilter(const PoseFilterParams& params) : ekf_(params) {}

  FilterStatus addEncoders(Stamp stamp, const Twist2& twist, Stamp received);
  FilterStatus addCommand(Stamp stamp, const Twist2& twist, Stamp received);
  FilterStatus addGyro(Stamp stamp, double rate_radps, Stamp received);
  FilterStatus addPose(Stamp stamp, const PoseFix& fix, Stamp received);
  FilterStatus addSighting(Stamp stamp, const LandmarkSighting& sighting, Stamp received);

  /// Puts the robot somewhere: what was measured until then no longer matters to its pose, and the biases
  /// stay. No gate refuses it, nor does setEnabled; bad values and stamps are refused. It counts as a pose.
  FilterStatus setPose(Stamp stamp, const PoseFix& fix, Stamp received);

  /// Time has jumped: forgets everything but the counts and what is enabled.
  void reset();
  /// Goes on with other parameters; throws ConfigError on bad ones and keeps those before.
  void setParams(const PoseFilterParams& params) { ekf_ = PoseEkf(params); }

  /// Inputs are enabled at first. One that is switched off goes on being believed until its time-out.
  void setEnabled(FilterInput input, bool enabled) { enabled_[static_cast<std::size_t>(input)] = enabled; }
  bool isEnabled(FilterInput input) const { return enabled_[static_cast<std::size_t>(input)]; }

  /// The newest estimate; nullopt before the first fix.
  std::optional<PoseEstimate> estimate() const;
  /// The estimate at an instant, predicted from the last measurement before it; nullopt also when that is
  /// older than the history.
  std::optional<PoseEstimate> estimateAt(Stamp stamp) const;

  const PoseFilterCounts& counts() const { return counts_; }

 private:
  struct EncoderTwist {
    Twist2 twist;
  };
  struct CommandTwist {
    Twist2 twist;
  };
  struct GyroRate {
    double rate_radps;
  };
  struct SetPose {
    PoseFix fix;
  };
  /// In the order in which measurements of one stamp are applied.
  using Measurement = std::variant<EncoderTwist, CommandTwist, GyroRate, PoseFix, LandmarkSighting, SetPose>;
  struct Record {
    Stamp stamp{};
    Measurement measurement;
    EkfState after;
    FilterStatus status = FilterStatus::kUsed;
    bool restarted = false;
  };
  struct Applier;
  struct FaultFinder;

  FilterStatus add(FilterInput input, Record record, Stamp received);
  FilterStatus judge(FilterInput input, const Record& record, Stamp received) const;
  FilterStatus insert(Record record);
  void apply(Record& record, const EkfState& before) const;
  void forgetOld();
  PoseEstimate toEstimate(const EkfState& state) const;

  PoseEkf ekf_;
  std::deque<Record> history_;  ///< in the order of (stamp, kind); the first one's state is settled
  std::optional<Stamp> last_received_;
  std::array<bool, kFilterInputs> enabled_{true, true, true, true, true};
  PoseFilterCounts counts_;
};

}  // namespace frugal_nav
