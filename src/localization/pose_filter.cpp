#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <Eigen/Cholesky>

#include <frugal_nav/localization/pose_filter.hpp>

namespace frugal_nav {
namespace {

template <class Matrix>
bool isCovariance(const Matrix& matrix) {
  return matrix.isApprox(matrix.transpose(), 1e-6) && matrix.llt().info() == Eigen::Success;
}

FilterStatus faultOf(bool finite, bool covariance) {
  if (!finite) return FilterStatus::kNotFinite;
  return covariance ? FilterStatus::kUsed : FilterStatus::kBadCovariance;
}

}  // namespace

const char* toText(FilterInput input) {
  switch (input) {
    case FilterInput::kEncoders:
      return "encoders";
    case FilterInput::kCommand:
      return "command";
    case FilterInput::kGyro:
      return "gyro";
    case FilterInput::kPose:
      return "pose";
    case FilterInput::kSighting:
      return "sighting";
  }
  return "";
}

const char* toText(FilterStatus status) {
  switch (status) {
    case FilterStatus::kUsed:
      return "used";
    case FilterStatus::kGated:
      return "refused by the gate";
    case FilterStatus::kNoFix:
      return "before the first fix";
    case FilterStatus::kNotFinite:
      return "not finite";
    case FilterStatus::kBadCovariance:
      return "covariance not positive definite";
    case FilterStatus::kFromFuture:
      return "stamp from the future";
    case FilterStatus::kTooOld:
      return "older than the history";
    case FilterStatus::kDisabled:
      return "switched off";
  }
  return "";
}

const char* toText(MotionSource source) {
  switch (source) {
    case MotionSource::kNone:
      return "neither twist nor gyro";
    case MotionSource::kTwistOnly:
      return "twist only, gyro silent";
    case MotionSource::kGyroOnly:
      return "gyro only, twist silent";
    case MotionSource::kTwistAndGyro:
      return "twist and gyro";
  }
  return "";
}

/// Applies a measurement to the state before it.
struct PoseFilter::Applier {
  const PoseEkf& ekf;
  const EkfState& before;
  Record& record;

  void operator()(const EncoderTwist& input) {
    record.after = ekf.withTwist(before, record.stamp, input.twist);
  }
  void operator()(const CommandTwist& input) {
    record.after = ekf.withTwist(before, record.stamp, input.twist);
  }
  void operator()(const GyroRate& input) {
    record.after = ekf.withGyro(before, record.stamp, input.rate_radps);
  }
  void operator()(const PoseFix& fix) { take(ekf.withPose(before, record.stamp, fix)); }
  void operator()(const SetPose& set) {
    record.after = PoseEkf::relocated(ekf.predicted(before, record.stamp), set.fix);
  }
  void operator()(const LandmarkSighting& sighting) {
    take(ekf.withSighting(before, record.stamp, sighting));
    if (!before.has_fix) record.status = FilterStatus::kNoFix;
  }
  void take(const PoseEkf::Corrected& corrected) {
    record.after = corrected.state;
    record.status = corrected.used ? FilterStatus::kUsed : FilterStatus::kGated;
    record.restarted = corrected.restarted;
  }
};

/// What is wrong with a measurement by itself.
struct PoseFilter::FaultFinder {
  FilterStatus operator()(const EncoderTwist& input) const { return faultOf(input.twist.isFinite(), true); }
  FilterStatus operator()(const CommandTwist& input) const { return faultOf(input.twist.isFinite(), true); }
  FilterStatus operator()(const GyroRate& input) const {
    return faultOf(std::isfinite(input.rate_radps), true);
  }
  FilterStatus operator()(const PoseFix& fix) const {
    return faultOf(fix.map_from_base.isFinite() && fix.covariance.allFinite(), isCovariance(fix.covariance));
  }
  FilterStatus operator()(const SetPose& set) const { return (*this)(set.fix); }
  FilterStatus operator()(const LandmarkSighting& seen) const {
    const bool finite = seen.p_map.allFinite() && std::isfinite(seen.range_m) &&
                        std::isfinite(seen.bearing_rad) && seen.covariance.allFinite();
    return faultOf(finite, isCovariance(seen.covariance));
  }
};

FilterStatus PoseFilter::addEncoders(Stamp stamp, const Twist2& twist, Stamp received) {
  return add(FilterInput::kEncoders, {stamp, EncoderTwist{twist}, {}}, received);
}

FilterStatus PoseFilter::addCommand(Stamp stamp, const Twist2& twist, Stamp received) {
  return add(FilterInput::kCommand, {stamp, CommandTwist{twist}, {}}, received);
}

FilterStatus PoseFilter::addGyro(Stamp stamp, double rate_radps, Stamp received) {
  return add(FilterInput::kGyro, {stamp, GyroRate{rate_radps}, {}}, received);
}

FilterStatus PoseFilter::addPose(Stamp stamp, const PoseFix& fix, Stamp received) {
  return add(FilterInput::kPose, {stamp, fix, {}}, received);
}

FilterStatus PoseFilter::addSighting(Stamp stamp, const LandmarkSighting& sighting, Stamp received) {
  return add(FilterInput::kSighting, {stamp, sighting, {}}, received);
}

FilterStatus PoseFilter::setPose(Stamp stamp, const PoseFix& fix, Stamp received) {
  return add(FilterInput::kPose, {stamp, SetPose{fix}, {}}, received);
}

FilterStatus PoseFilter::add(FilterInput input, Record record, Stamp received) {
  if (last_received_ && received + fromSeconds(ekf_.params().jump_back_s) < *last_received_) reset();
  last_received_ = last_received_ ? std::max(*last_received_, received) : received;
  FilterStatus status = judge(input, record, received);
  if (status == FilterStatus::kUsed) status = insert(std::move(record));
  ++counts_.measurements[static_cast<std::size_t>(input)][static_cast<std::size_t>(status)];
  return status;
}

void PoseFilter::reset() {
  history_.clear();
  last_received_.reset();
  ++counts_.time_jumps;
}

FilterStatus PoseFilter::judge(FilterInput input, const Record& record, Stamp received) const {
  const bool is_set = std::holds_alternative<SetPose>(record.measurement);
  const FilterInput unused =
      ekf_.params().twist_source == "encoders" ? FilterInput::kCommand : FilterInput::kEncoders;
  if (input == unused || (!isEnabled(input) && !is_set)) return FilterStatus::kDisabled;
  const FilterStatus fault = std::visit(FaultFinder{}, record.measurement);
  if (fault != FilterStatus::kUsed) return fault;
  if (record.stamp > received + fromSeconds(ekf_.params().future_tolerance_s))
    return FilterStatus::kFromFuture;
  if (!history_.empty() && record.stamp < history_.front().stamp) return FilterStatus::kTooOld;
  return FilterStatus::kUsed;
}

FilterStatus PoseFilter::insert(Record record) {
  const auto goesBefore = [](const Record& a, const Record& b) {
    return std::pair(a.stamp, a.measurement.index()) < std::pair(b.stamp, b.measurement.index());
  };
  auto place = std::upper_bound(history_.begin(), history_.end(), record, goesBefore);
  // The first record's state is settled: what goes before it at the same stamp is applied after it.
  if (place == history_.begin() && !history_.empty()) ++place;
  if (place != history_.end()) ++counts_.late;
  place = history_.insert(place, std::move(record));
  for (auto it = place; it != history_.end(); ++it) {
    const bool had_restarted = it->restarted;
    apply(*it, it == history_.begin() ? ekf_.initial(it->stamp) : std::prev(it)->after);
    if (it->restarted && !had_restarted) ++counts_.restarts;
  }
  const FilterStatus status = place->status;
  forgetOld();
  return status;
}

void PoseFilter::apply(Record& record, const EkfState& before) const {
  std::visit(Applier{ekf_, before, record}, record.measurement);
}

void PoseFilter::forgetOld() {
  const Stamp oldest = history_.back().stamp - fromSeconds(ekf_.params().history_s);
  while (history_.front().stamp < oldest) history_.pop_front();
}

std::optional<PoseEstimate> PoseFilter::estimate() const {
  if (history_.empty() || !history_.back().after.has_fix) return std::nullopt;
  return toEstimate(history_.back().after);
}

std::optional<PoseEstimate> PoseFilter::estimateAt(Stamp stamp) const {
  const auto later = std::upper_bound(history_.begin(), history_.end(), stamp,
                                      [](Stamp at, const Record& record) { return at < record.stamp; });
  if (later == history_.begin()) return std::nullopt;
  const EkfState& before = std::prev(later)->after;
  if (!before.has_fix) return std::nullopt;
  return toEstimate(ekf_.predicted(before, stamp));
}

PoseEstimate PoseFilter::toEstimate(const EkfState& state) const {
  PoseEstimate estimate;
  estimate.stamp = state.stamp;
  estimate.map_from_base = {state.mean[kEkfX], state.mean[kEkfY], state.mean[kEkfYaw]};
  estimate.covariance = state.covariance.topLeftCorner<3, 3>();
  estimate.gyro_bias_radps = state.mean[kEkfGyroBias];
  estimate.scale = state.mean[kEkfScale];
  estimate.rate_bias_radps = state.mean[kEkfRateBias];
  estimate.source = ekf_.motionSource(state);
  return estimate;
}

}  // namespace frugal_nav
