#include <algorithm>
#include <cmath>

#include <frugal_nav/planning/dynamic_window.hpp>

namespace frugal_nav {
namespace {

constexpr double kStep_m = 0.04;  // no point of the body moves farther between two checked poses

double sample(double low, double high, int i, int count) { return low + (high - low) * i / (count - 1); }

}  // namespace

DynamicWindow::DynamicWindow(const DynamicWindowParams& params, const SpeedParams& speed,
                             const BodyExtent& body)
    : params_(params), speed_(speed, body), body_(body) {
  validate(params, "dwa");
}

/// How far the rim of the body moves on an arc before the footprint and its margin touch a point.
double DynamicWindow::freeWay(const Twist2& velocity,
                              const std::vector<Eigen::Vector2d>& obstacles_base) const {
  const double rim_mps = std::abs(velocity.v_mps) + std::abs(velocity.w_radps) * body_.circumradius_m;
  if (rim_mps <= 0.0) return params_.horizon_m;
  const double half_length_m = body_.front_m() + params_.margin_m;
  const double half_width_m = body_.half_width_m + params_.margin_m;
  const Pose2 step = arcMotion(velocity, kStep_m / rim_mps);
  Pose2 pose = step;
  for (double way_m = kStep_m; way_m < params_.horizon_m; way_m += kStep_m, pose = pose * step) {
    const double c = std::cos(pose.yaw_rad);
    const double s = std::sin(pose.yaw_rad);
    for (const Eigen::Vector2d& p : obstacles_base) {
      const double dx = p.x() - pose.x_m;
      const double dy = p.y() - pose.y_m;
      if (std::abs(c * dx + s * dy) < half_length_m && std::abs(c * dy - s * dx) < half_width_m)
        return way_m - kStep_m;
    }
  }
  return params_.horizon_m;
}

// Admissible (V_a): v <= sqrt(2 d a) and likewise the turn, after what the reaction takes.
bool DynamicWindow::isAdmissible(const Twist2& velocity, double way_m) const {
  const double turn_rim_m =
      velocity.w_radps * velocity.w_radps / (2.0 * params_.turn_accel_radps2) * body_.circumradius_m;
  return velocity.v_mps <= speed_.stoppable_mps(way_m) && turn_rim_m <= way_m;
}

double DynamicWindow::value(const Twist2& velocity, double way_m, const Eigen::Vector2d& target_base) const {
  const Pose2 then = arcMotion(velocity, params_.heading_after_s);
  const double heading = 1.0 - std::abs(bearingTo(then, target_base)) / M_PI;
  return params_.heading_weight * heading + params_.clearance_weight * way_m / params_.horizon_m +
         params_.speed_weight * velocity.v_mps / speed_.params().max_v_mps;
}

std::vector<DynamicWindow::Choice> DynamicWindow::rate(
    const Twist2& present, const Eigen::Vector2d& target_base, double fastest_mps,
    const std::vector<Eigen::Vector2d>& obstacles_base) const {
  const double dv = params_.accel_mps2 * params_.period_s;
  const double dw = params_.turn_accel_radps2 * params_.period_s;
  const double max_w = speed_.params().max_w_radps;
  const double low_v = std::clamp(present.v_mps - dv, 0.0, fastest_mps);
  const double high_v = std::clamp(present.v_mps + dv, 0.0, fastest_mps);
  const double low_w = std::clamp(present.w_radps - dw, -max_w, max_w);
  const double high_w = std::clamp(present.w_radps + dw, -max_w, max_w);
  std::vector<Choice> choices;
  for (int j = 0; j < params_.turns; ++j) {
    for (int i = 0; i < params_.speeds; ++i) {
      Choice choice;
      choice.velocity = {sample(low_v, high_v, i, params_.speeds), sample(low_w, high_w, j, params_.turns)};
      const double way_m = freeWay(choice.velocity, obstacles_base);
      choice.admissible = isAdmissible(choice.velocity, way_m);
      choice.value = value(choice.velocity, way_m, target_base);
      choices.push_back(choice);
    }
  }
  return choices;
}

/// The admissible choice whose value, smoothed over the neighbouring turn rates, is the largest.
const DynamicWindow::Choice* DynamicWindow::best(const std::vector<Choice>& choices) const {
  const Choice* best = nullptr;
  double highest = 0.0;
  const int count = static_cast<int>(choices.size());
  for (int i = 0; i < count; ++i) {
    if (!choices[static_cast<std::size_t>(i)].admissible) continue;
    double sum = 0.0;
    int summed = 0;
    for (const int k : {i - params_.speeds, i, i + params_.speeds}) {
      if (k < 0 || k >= count) continue;
      sum += choices[static_cast<std::size_t>(k)].value;
      ++summed;
    }
    if (best != nullptr && sum / summed <= highest) continue;
    highest = sum / summed;
    best = &choices[static_cast<std::size_t>(i)];
  }
  return best;
}

MotionCommand DynamicWindow::plan(const LocalPlannerInput& input) {
  const Pose2 base_from_odom = input.odometry.odom_from_base.inverse();
  const double reach_m = params_.horizon_m + body_.circumradius_m + params_.margin_m;
  const std::vector<Eigen::Vector2d> p_base =
      placesFrom(input.odometry.odom_from_base,
                 input.window->pointsWithin(input.odometry.odom_from_base.position(), reach_m));

  MotionCommand command;
  command.stamp = input.scan.stamp;
  const Eigen::Vector2d target = base_from_odom * input.target_odom;
  command.clear_bearing_rad = clearBearing(input);
  const double to_goal_m = std::min((base_from_odom * input.goal_odom).norm(), input.way_m);
  const double fastest_mps = std::min(speed_.params().max_v_mps, speed_.stoppable_mps(to_goal_m));
  const std::vector<Choice> choices = rate(input.odometry.twist, target, fastest_mps, p_base);
  const Choice* chosen = best(choices);
  if (chosen == nullptr) {
    command.status = MotionCommand::Status::kBlocked;
    command.reason = "no velocity it could stop from in time";
    return command;
  }
  command.status = MotionCommand::Status::kDriving;
  command.holds = MotionCommand::Holds::kVelocity;
  command.velocity = chosen->velocity;
  return command;
}

}  // namespace frugal_nav
