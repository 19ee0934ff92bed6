#include <algorithm>
#include <cmath>

#include <frugal_nav/planning/corridor.hpp>
#include <frugal_nav/planning/sector_avoidance.hpp>

namespace frugal_nav {
namespace {

constexpr double kFacing_rad = 0.26;     // turning further toward the clear side would change nothing
constexpr double kTurningRoom_m = 0.01;  // beside the circumradius, to turn on the spot

}  // namespace

std::string SectorParams::check() const {
  if (last_margin_m > first_margin_m) return "last_margin_m is above first_margin_m";
  if (last_distance_m > first_distance_m) return "last_distance_m is above first_distance_m";
  return {};
}

SectorAvoidance::SectorAvoidance(const SectorParams& params, const BodyExtent& body)
    : params_(params), body_(body), decision_{SectorRing(params.sectors)} {
  validate(params, "sectors");
  if (!(body.half_width_m > 0.0) || !(body.circumradius_m >= body.half_width_m)) {
    throw ConfigError("sectors: the body's half width must be positive and not above its circumradius");
  }
}

void SectorAvoidance::reset() {
  previous_odom_rad_.reset();
  turning_since_.reset();
}

MotionCommand SectorAvoidance::plan(const LocalPlannerInput& input) {
  const Pose2& base = input.odometry.odom_from_base;
  const Wanted wanted{bearingTo(base, input.target_odom), (input.target_odom - base.position()).norm()};
  const SectorRing ring(params_.sectors);
  const std::vector<bool> observed = observedSectors(ring, input.scan, input.base_from_laser);

  MotionCommand command;
  command.stamp = input.scan.stamp;
  command.clear_bearing_rad = clearBearing(input);
  decision_ = decide(input, wanted, observed);
  return decision_.found ? drive(input, wanted, command) : turn(input, command);
}

SectorAvoidance::Blocking SectorAvoidance::blocking(int narrowing) const {
  if (narrowing == 0) {
    return {params_.block_distance_m, params_.block_half_width_rad,
            body_.half_width_m + params_.last_margin_m};
  }
  const double f = params_.narrowings == 1 ? 1.0 : (narrowing - 1.0) / (params_.narrowings - 1.0);
  const double margin = params_.first_margin_m + f * (params_.last_margin_m - params_.first_margin_m);
  return {params_.first_distance_m + f * (params_.last_distance_m - params_.first_distance_m), 0.0,
          body_.half_width_m + margin};
}

SectorRing SectorAvoidance::block(const Blocking& rule, const LocalPlannerInput& input,
                                  double target_distance_m, const std::vector<bool>& observed) const {
  SectorRing ring(params_.sectors);
  for (int i = 0; i < ring.size(); ++i) {
    if (!observed[static_cast<std::size_t>(i)]) ring.block(i);
  }
  const double within = std::min(rule.distance_m, target_distance_m + params_.goal_margin_m);
  for (const Eigen::Vector2d& p : input.obstacles_base) {
    const double range = p.norm();
    if (range > within) continue;
    const double body_angle = std::asin(std::min(1.0, rule.body_half_width_m / std::max(range, 1e-9)));
    const double bearing = std::atan2(p.y(), p.x());
    ring.blockAround(bearing, body_angle);
    // The paper blocks whole sectors around a blocked sector, so the fixed part counts from its centre.
    if (rule.half_width_rad > 0.0)
      ring.blockAround(ring.bearingOf(ring.sectorOf(bearing)), rule.half_width_rad);
  }
  return ring;
}

/// The free direction nearest to the wanted one; of two equal ones, left and right of it, the nearer to the
/// previous direction.
std::optional<double> SectorAvoidance::choose(const SectorRing& ring, double wanted_rad,
                                              double max_detour_rad, double heading_rad) const {
  if (ring.isFree(ring.sectorOf(wanted_rad))) return wanted_rad;
  std::optional<double> left;
  std::optional<double> right;
  for (int i = 0; i < ring.size(); ++i) {
    const double detour = angleBetween(wanted_rad, ring.bearingOf(i));
    if (!ring.isFree(i) || std::abs(detour) > max_detour_rad) continue;
    std::optional<double>& side = detour > 0.0 ? left : right;
    if (!side || std::abs(detour) < std::abs(*side)) side = detour;
  }
  if (!left && !right) return std::nullopt;
  if (!left || !right) return wrapAngle(wanted_rad + (left ? *left : *right));
  bool goes_left = *left <= -*right;
  if (std::abs(*left + *right) < params_.tie_rad && previous_odom_rad_) {
    const double previous = angleBetween(wanted_rad, angleBetween(heading_rad, *previous_odom_rad_));
    goes_left = std::abs(angleBetween(previous, *left)) <= std::abs(angleBetween(previous, *right));
  }
  return wrapAngle(wanted_rad + (goes_left ? *left : *right));
}

SectorAvoidance::Decision SectorAvoidance::decide(const LocalPlannerInput& input, const Wanted& wanted,
                                                  const std::vector<bool>& observed) const {
  std::vector<SectorRing> rings;
  for (int narrowing = 0; narrowing <= params_.narrowings; ++narrowing) {
    rings.push_back(block(blocking(narrowing), input, wanted.distance_m, observed));
  }
  const double heading = input.odometry.odom_from_base.yaw_rad;
  const auto reach = [&](int narrowing) {
    const Blocking rule = blocking(narrowing);
    return std::max(0.05, rule.distance_m - rule.body_half_width_m);
  };
  const auto search = [&](double max_detour_rad) -> std::optional<Decision> {
    for (int narrowing = 0; narrowing <= params_.narrowings; ++narrowing) {
      const SectorRing& ring = rings[static_cast<std::size_t>(narrowing)];
      if (const auto bearing = choose(ring, wanted.bearing_rad, max_detour_rad, heading)) {
        return Decision{ring, narrowing, true, *bearing, reach(narrowing)};
      }
    }
    return std::nullopt;
  };

  const Pose2 base_from_odom = input.odometry.odom_from_base.inverse();
  const int target_sector = rings.front().sectorOf(wanted.bearing_rad);
  const Blocking first = blocking(std::min(1, params_.narrowings));
  const Corridor straight{base_from_odom * input.target_odom, first.body_half_width_m, body_.half_width_m};
  if (!rings.front().isFree(target_sector) && observed[static_cast<std::size_t>(target_sector)] &&
      isFree(straight, input.obstacles_base)) {
    return Decision{rings.front(), 0, true, wanted.bearing_rad, wanted.distance_m};
  }
  if (const auto near = search(params_.max_detour_rad)) return *near;
  if (const auto any = search(M_PI)) return *any;
  return Decision{rings.back(), params_.narrowings, false, 0.0, 0.0};
}

MotionCommand SectorAvoidance::drive(const LocalPlannerInput& input, const Wanted& wanted,
                                     MotionCommand command) {
  const Pose2& base = input.odometry.odom_from_base;
  const double step = std::min({params_.step_m, wanted.distance_m, decision_.reach_m});
  const double direction = wrapAngle(base.yaw_rad + decision_.bearing_rad);
  command.status = MotionCommand::Status::kDriving;
  command.holds = MotionCommand::Holds::kTarget;
  command.odom_from_target = {base.x_m + step * std::cos(direction), base.y_m + step * std::sin(direction),
                              direction};
  previous_odom_rad_ = direction;
  turning_since_.reset();
  return command;
}

MotionCommand SectorAvoidance::turn(const LocalPlannerInput& input, MotionCommand command) {
  if (!turning_since_) turning_since_ = input.scan.stamp;
  const double swept = body_.circumradius_m + kTurningRoom_m;
  const bool can_turn = std::none_of(input.obstacles_base.begin(), input.obstacles_base.end(),
                                     [swept](const Eigen::Vector2d& p) { return p.norm() < swept; });
  const bool facing = std::abs(command.clear_bearing_rad) < kFacing_rad;
  const bool tired = toSeconds(input.scan.stamp - *turning_since_) >= params_.turn_time_s;
  if (!can_turn || facing || tired) {
    command.status = MotionCommand::Status::kBlocked;
    command.reason = "no free direction, even at the body's own width";
    return command;
  }
  command.status = MotionCommand::Status::kTurning;
  command.reason = "no free direction: turning toward the larger clearance";
  command.holds = MotionCommand::Holds::kVelocity;
  command.velocity.w_radps = std::copysign(params_.turn_rate_radps, command.clear_bearing_rad);
  return command;
}

}  // namespace frugal_nav
