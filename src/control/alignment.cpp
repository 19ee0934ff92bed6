#include <algorithm>
#include <cmath>
#include <limits>

#include <frugal_nav/control/alignment.hpp>

namespace frugal_nav {

Alignment::Alignment(const AlignmentParams& params) : params_(params) { validate(params, "alignment"); }

void Alignment::reset() { last_stamp_.reset(); }

AlignmentStep Alignment::updateBearing(Stamp stamp, double view_rad, double bearing_rad) {
  // A bearing outside the view counts as at the image's edge and beyond: the same side, the fastest turn.
  constexpr double kWidest_rad = 1.4;
  const double focal = 0.5 / std::tan(0.5 * view_rad);
  return update(stamp, 1, 0.5 - focal * std::tan(std::clamp(bearing_rad, -kWidest_rad, kWidest_rad)));
}

AlignmentStep Alignment::update(Stamp stamp, int image_width_px, std::optional<double> target_column_px) {
  if (!last_stamp_ || stamp < *last_stamp_) last_seen_ = stamp;  // a fresh start has the whole time
  last_stamp_ = stamp;
  AlignmentStep step;
  step.error_px = std::numeric_limits<double>::quiet_NaN();
  if (image_width_px <= 0 || !target_column_px || !std::isfinite(*target_column_px)) {
    const bool is_lost = toSeconds(stamp - last_seen_) > params_.lost_after_s;
    step.status = is_lost ? AlignmentStep::Status::kLost : AlignmentStep::Status::kWaiting;
    return step;
  }
  last_seen_ = stamp;
  step.error_px = 0.5 * image_width_px - *target_column_px;
  const double share = step.error_px / image_width_px;
  if (std::abs(share) <= params_.tolerance_share) {
    step.status = AlignmentStep::Status::kDone;
    return step;
  }
  step.status = share > 0.0 ? AlignmentStep::Status::kTurningLeft : AlignmentStep::Status::kTurningRight;
  const double turn = std::clamp(params_.turn_per_share_radps * std::abs(share), params_.min_turn_radps,
                                 params_.max_turn_radps);
  step.w_radps = std::copysign(turn, share);
  return step;
}

}  // namespace frugal_nav
