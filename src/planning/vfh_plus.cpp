#include <algorithm>
#include <cmath>

#include <frugal_nav/planning/corridor.hpp>
#include <frugal_nav/planning/vfh_plus.hpp>

namespace frugal_nav {
namespace {

constexpr double kFacing_rad = 0.26;   // turning further toward the clear side would change nothing
constexpr double kSlowest_mps = 0.05;  // below this the robot can turn on the spot

}  // namespace

double VfhPlus::directionTo(const Pose2& from, const Eigen::Vector2d& p) {
  return std::atan2(p.y() - from.y_m, p.x() - from.x_m);
}

VfhPlus::VfhPlus(const VfhParams& params, const SpeedParams& speed, const BodyExtent& body)
    : params_(params),
      body_(body),
      speed_(speed, body),
      decision_{SectorRing(params.histogram.sectors), SectorRing(params.histogram.sectors), {}, {}, 0.0} {
  validate(params, "vfh");
  reset();
}

void VfhPlus::reset() {
  previous_.clear();
  previous_odom_rad_.reset();
  turning_since_.reset();
}

double VfhPlus::turningRadius(const Twist2& twist) const {
  const double v = std::abs(twist.v_mps);
  return v < kSlowest_mps ? 0.0 : v / speed_.params().max_w_radps;
}

PolarHistogram VfhPlus::histogramAt(const Place& place, const std::vector<WindowPoint>& points,
                                    const SectorRing* previous) const {
  const Pose2& pose = place.odom_from_base;
  const double to_target_m = (place.target_odom - pose.position()).norm();
  return PolarHistogram(params_.histogram,
                        {pose.position(), pose.yaw_rad, place.enlargement_m, place.turning_radius_m,
                         to_target_m + params_.goal_margin_m},
                        points, previous);
}

double VfhPlus::cost(double direction_rad, double target_rad, double heading_rad, double previous_rad) const {
  return params_.mu_target * std::abs(angleBetween(direction_rad, target_rad)) +
         params_.mu_heading * std::abs(angleBetween(direction_rad, heading_rad)) +
         params_.mu_previous * std::abs(angleBetween(direction_rad, previous_rad));
}

double VfhPlus::choose(const Place& place, const std::vector<double>& candidates,
                       const std::vector<WindowPoint>& /*points*/) const {
  const double target = directionTo(place.odom_from_base, place.target_odom);
  const double heading = place.odom_from_base.yaw_rad;
  return *std::min_element(candidates.begin(), candidates.end(), [&](double a, double b) {
    return cost(a, target, heading, previous(target)) < cost(b, target, heading, previous(target));
  });
}

/// Where no safety distance opens a direction near the target's: straight at it all the same, if the body
/// just fits, which a valley narrower than a sector does not show; else the first other direction.
void VfhPlus::takeDetour(const LocalPlannerInput& input, const std::vector<Eigen::Vector2d>& p_base,
                         double target_rad, const std::vector<Decision>& others) {
  const Corridor straight{input.odometry.odom_from_base.inverse() * input.target_odom,
                          body_.half_width_m + 0.5 * params_.least_safety_m, body_.front_m()};
  if (isFree(straight, p_base)) {
    decision_.candidates_odom_rad.push_back(target_rad);
    decision_.chosen_odom_rad = target_rad;
    return;
  }
  const auto nearer = std::find_if(others.begin(), others.end(), [&](const Decision& other) {
    return std::abs(angleBetween(*other.chosen_odom_rad, target_rad)) <= params_.max_detour_rad;
  });
  if (nearer != others.end()) {
    decision_ = *nearer;
  } else if (!others.empty()) {
    decision_ = others.front();
  }
}

bool VfhPlus::decide(const LocalPlannerInput& input, const std::vector<WindowPoint>& points,
                     const std::vector<Eigen::Vector2d>& p_base) {
  Place place{input.odometry.odom_from_base, input.target_odom, turningRadius(input.odometry.twist), 0.0};
  const double target = directionTo(place.odom_from_base, input.target_odom);
  std::vector<SectorRing> binaries;
  std::vector<Decision> others;  // of each safety distance that leads far from the target
  for (int i = 0; i <= params_.narrowings; ++i) {
    const double safety =
        params_.safety_m + (params_.least_safety_m - params_.safety_m) * i / params_.narrowings;
    place.enlargement_m = body_.half_width_m + safety;
    const auto level = static_cast<std::size_t>(i);
    const PolarHistogram histogram =
        histogramAt(place, points, level < previous_.size() ? &previous_[level] : nullptr);
    binaries.push_back(histogram.binary());
    decision_ = {histogram.binary(), histogram.masked(), histogram.candidates(target), {}, safety};
    if (decision_.candidates_odom_rad.empty()) continue;
    decision_.chosen_odom_rad = choose(place, decision_.candidates_odom_rad, points);
    if (std::abs(angleBetween(*decision_.chosen_odom_rad, target)) <= params_.near_rad) break;
    others.push_back(decision_);
    decision_.chosen_odom_rad.reset();
  }
  if (!decision_.chosen_odom_rad) takeDetour(input, p_base, target, others);
  for (std::size_t i = 0; i < binaries.size(); ++i) {
    if (i < previous_.size())
      previous_[i] = binaries[i];
    else
      previous_.push_back(binaries[i]);
  }
  previous_odom_rad_ = decision_.chosen_odom_rad;
  return decision_.chosen_odom_rad.has_value();
}

MotionCommand VfhPlus::plan(const LocalPlannerInput& input) {
  const Pose2& base = input.odometry.odom_from_base;
  const std::vector<WindowPoint> points =
      input.window->pointsWithin(base.position(), 2.0 * params_.histogram.radius_m);
  const std::vector<Eigen::Vector2d> p_base = placesFrom(base, points);

  MotionCommand command;
  command.stamp = input.scan.stamp;
  command.clear_bearing_rad = clearBearing(input);
  if (!decide(input, points, p_base)) return turn(input, command);
  turning_since_.reset();
  command.status = MotionCommand::Status::kDriving;
  command.holds = MotionCommand::Holds::kVelocity;
  command.velocity = speed_.choose(angleBetween(base.yaw_rad, *decision_.chosen_odom_rad),
                                   std::min((input.goal_odom - base.position()).norm(), input.way_m), p_base);
  return command;
}

MotionCommand VfhPlus::turn(const LocalPlannerInput& input, MotionCommand command) {
  if (!turning_since_) turning_since_ = input.scan.stamp;
  const bool facing = std::abs(command.clear_bearing_rad) < kFacing_rad;
  const bool tired = toSeconds(input.scan.stamp - *turning_since_) >= params_.turn_time_s;
  if (facing || tired) {
    command.status = MotionCommand::Status::kBlocked;
    command.reason = "no free direction, even at the body's own width";
    return command;
  }
  command.status = MotionCommand::Status::kTurning;
  command.reason = "no free direction: turning toward the larger clearance";
  command.holds = MotionCommand::Holds::kVelocity;
  command.velocity.w_radps = std::copysign(0.6 * speed_.params().max_w_radps, command.clear_bearing_rad);
  return command;
}

}  // namespace frugal_nav
