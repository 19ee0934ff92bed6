#include <algorithm>
#include <cstdio>
#include <limits>

#include <frugal_nav/planning/camera_planner.hpp>
#include <frugal_nav/planning/path_shape.hpp>

namespace frugal_nav {
namespace {

constexpr double kFarthest_m = 1e6;  // beyond this cell indices no longer fit
constexpr double kInfinite = std::numeric_limits<double>::infinity();
// A way no longer than this, in straight lines to the goal, is not compared with others.
constexpr double kShortDetour = 1.25;
// A path that ends nearer than this is not worth starting.
constexpr double kShortest_m = 0.08;

bool isUsable(const Pose2& pose) {
  return pose.isFinite() && std::abs(pose.x_m) < kFarthest_m && std::abs(pose.y_m) < kFarthest_m;
}

/// The body in a passage: never nearer to an obstacle than its margin, nor in one narrower than allowed.
CostMapParams mapParams(const CameraPlannerParams& params, const BodyExtent& body) {
  CostMapParams map = params.cost;
  const double half_gap_m = params.halt_width_factor * body.half_width_m - params.width_slack_m;
  map.lethal_margin_m = std::max(map.lethal_margin_m, half_gap_m - body.half_width_m);
  return map;
}

std::string metres(double m) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f m", m);
  return text;
}

}  // namespace

CameraPlanner::CameraPlanner(const CameraPlannerParams& params, const BodyExtent& body)
    : params_(params),
      body_(body),
      memory_(params.memory),
      cost_map_(mapParams(params, body), body, memory_.grid()),
      astar_(params.astar) {
  validate(params, "camera planner");
}

void CameraPlanner::setParams(const CameraPlannerParams& params) {
  validate(params, "camera planner");
  params_ = params;
  memory_.setParams(params.memory);
  cost_map_ = CostMap(mapParams(params, body_), body_, memory_.grid());
  astar_.setParams(params.astar);
  path_.clear();
}

void CameraPlanner::setGoal(const std::optional<Pose2>& odom_from_goal,
                            const std::optional<Eigen::Vector2d>& p_odom_person) {
  if (!odom_from_goal) {
    mission_started_ = false;
    path_.clear();
  }
  goal_ = odom_from_goal;
  p_odom_person_ = p_odom_person;
}

void CameraPlanner::reset() {
  memory_.reset();
  path_.clear();
  mission_started_ = false;
}

CameraPlan CameraPlanner::update(const CameraObservation& observation) {
  CameraPlan plan;
  plan.stamp = observation.stamp;
  plan.robot = observation.odometry.odom_from_base;
  plan.status = CameraPlan::Status::kStopped;
  plan.reason = findFault(observation);
  if (!plan.reason.empty()) {
    path_.clear();
    return plan;
  }
  memory_.insert(observation.scan, observation.obstacle, plan.robot, p_odom_person_);
  cost_map_.update(memory_.grid(), memory_.grid().cellOf(plan.robot.position()), params_.assumed_depth_m);
  plan.moving = memory_.moving();
  plan.gap = gapNode(observation.gap);
  if (observation.obstacle.found) plan.obstacle = observation.obstacle;
  plan.status = CameraPlan::Status::kIdle;
  if (!goal_) return plan;
  if (!mission_started_) astar_.startMission(plan.robot.position(), goal_->position());
  mission_started_ = true;
  astar_.moveGoal(goal_->position());

  plan.replanned = replanReason(observation);
  if (!plan.replanned.empty()) search(observation, plan);
  if (path_.empty()) return plan;
  plan.status = CameraPlan::Status::kFound;
  plan.path = rest(plan.robot);
  plan.reaches_goal = planned_.reaches_goal;
  plan.through_gap = planned_.through_gap;
  giveWay(plan);
  return plan;
}

std::string CameraPlanner::findFault(const CameraObservation& observation) const {
  if (!observation.fault.empty()) return observation.fault;
  if (const auto fault = frugal_nav::findFault(observation.scan)) return "depth scan: " + *fault;
  if (!isUsable(observation.odometry.odom_from_base)) return "the robot's pose is not finite";
  if (observation.gap.found && !observation.gap.p_odom.allFinite()) return "the gap is not finite";
  if (observation.obstacle.found && !observation.obstacle.p_odom.allFinite())
    return "the nearest obstacle is not finite";
  if (goal_ && !isUsable(*goal_)) return "the goal is not finite";
  return "";
}

bool CameraPlanner::isNarrow(const GapSighting& gap) const {
  return gap.found && std::isfinite(gap.width_m) &&
         gap.width_m < params_.halt_width_factor * 2.0 * body_.half_width_m;
}

/// What the image says against driving on; by itself the end of it in the literal mode only, since the memory
/// may know another way.
std::string CameraPlanner::haltReason(const GapSighting& gap) const {
  if (!gap.found) return "no gap" + (gap.reason.empty() ? "" : ": " + gap.reason);
  if (!isNarrow(gap)) return "";
  char factor[16];
  std::snprintf(factor, sizeof factor, "%.1f", params_.halt_width_factor);
  return "the gap is " + metres(gap.width_m) + " wide, less than " + factor + " robot widths";
}

std::optional<Eigen::Vector2d> CameraPlanner::gapNode(const GapSighting& gap) const {
  if (!gap.found || isNarrow(gap)) return std::nullopt;
  return gap.p_odom;
}

std::optional<Eigen::Vector2d> CameraPlanner::nearObstacle(const CameraObservation& observation) const {
  const NearestObstacle& obstacle = observation.obstacle;
  if (!obstacle.found) return std::nullopt;
  const double away_m = (obstacle.p_odom - observation.odometry.odom_from_base.position()).norm();
  if (away_m > params_.replan.obstacle_m) return std::nullopt;
  return obstacle.p_odom;
}

std::string CameraPlanner::replanReason(const CameraObservation& observation) const {
  const ReplanParams& rules = params_.replan;
  if (path_.empty()) return "no path yet";
  if ((goal_->position() - planned_.goal).norm() > rules.goal_moved_m) return "the goal moved";
  const Path2 ahead = rest(observation.odometry.odom_from_base);
  if (!isLiteral() && isClosed(ahead)) return "the path is blocked";
  if ((ahead.front().position() - observation.odometry.odom_from_base.position()).norm() > rules.off_path_m)
    return "off the path";
  const std::optional<Eigen::Vector2d> obstacle = nearObstacle(observation);
  if (obstacle &&
      (!planned_.near_obstacle || (*obstacle - *planned_.near_obstacle).norm() > rules.obstacle_moved_m))
    return "an obstacle is near";
  const std::optional<Eigen::Vector2d> gap = gapNode(observation.gap);
  if (gap.has_value() != planned_.gap.has_value() ||
      (gap && (*gap - *planned_.gap).norm() > rules.gap_moved_m))
    return "the gap changed";
  const double age_s = toSeconds(observation.stamp - planned_.stamp);
  if (age_s >= rules.period_s || age_s < 0.0) return "time";
  return "";
}

bool CameraPlanner::isClosed(const Path2& path) const {
  return std::any_of(path.begin(), path.end(), [&](const Pose2& pose) {
    const Cell cell = cost_map_.toWindow(memory_.grid().cellOf(pose.position()));
    return cost_map_.weights().contains(cell) && !cost_map_.weights().isPassable(cell);
  });
}

ModifiedAStar::Cost CameraPlanner::costOf(const CameraObservation& observation) const {
  if (isLiteral()) {  // the nodes of one image alone
    if (!observation.obstacle.found) return [](const Eigen::Vector2d&) { return 1.0; };
    const Eigen::Vector2d obstacle = observation.obstacle.p_odom;
    const double inflated_m = body_.circumradius_m + params_.cost.lethal_margin_m;
    return [obstacle, inflated_m](const Eigen::Vector2d& p) {
      return (p - obstacle).norm() < inflated_m ? kInfinite : 1.0;
    };
  }
  const double keep_m = keepOffPerson_m(observation.odometry.odom_from_base.position());
  return [this, keep_m](const Eigen::Vector2d& p) {
    if (p_odom_person_ && (p - *p_odom_person_).norm() < keep_m) return kInfinite;
    const Cell in_window = cost_map_.toWindow(memory_.grid().cellOf(p));
    const WeightGrid& weights = cost_map_.weights();
    if (!weights.contains(in_window)) return params_.cost.unknown_weight;
    if (!weights.isPassable(in_window)) return kInfinite;
    return static_cast<double>(weights.weights[weights.index(in_window)]) / WeightGrid::kFree;
  };
}

/// How far a path keeps off the person who is the goal, whom the memory leaves out: so that the robot does
/// not touch it, or where it is nearer already comes no nearer still. 0 where there is none.
double CameraPlanner::keepOffPerson_m(const Eigen::Vector2d& p_odom_robot) const {
  constexpr double kPerson_m = 0.25;  // a person's radius
  if (!p_odom_person_) return 0.0;
  return std::min(kPerson_m + body_.circumradius_m, (p_odom_robot - *p_odom_person_).norm());
}

/// Weighs the places around the robot by what is trusted of the memory.
void CameraPlanner::weigh(Trust trust, const Eigen::Vector2d& p_odom_robot, const Path2& before) {
  const Cell robot = memory_.grid().cellOf(p_odom_robot);
  if (trust == Trust::kCertain) {
    cost_map_.updateCertain(memory_.grid(), robot, params_.doubtful_certainty, params_.doubtful_from_m);
  } else {
    cost_map_.update(memory_.grid(), robot, trust == Trust::kFarSides ? params_.assumed_depth_m : 0.0);
  }
  cost_map_.prefer(before, params_.same_way_m, params_.switch_gain);
}

/// Around the far sides of what is seen; where that way is long, past them or through what is doubtful, if
/// that costs far less. Leaves the cost map as the way was searched for.
ModifiedAStar::Result CameraPlanner::findWay(const ModifiedAStar::Query& query, const Path2& before,
                                             const ModifiedAStar::Cost& cost) {
  using Result = ModifiedAStar::Result;
  const double straight_m = (query.goal - query.robot).norm();
  const auto isFound = [](const Result& way) { return way.status == Result::Status::kFound; };
  const auto isShort = [&](const Result& way) {
    return isFound(way) && way.length_m <= kShortDetour * straight_m;
  };
  const auto isWorse = [&](const Result& way, const Result& other) {
    return !isFound(way) || (isFound(other) && way.cost > params_.far_side_detour * other.cost);
  };
  Trust chosen = params_.assumed_depth_m > 0.0 ? Trust::kFarSides : Trust::kSeen;
  weigh(chosen, query.robot, before);
  Result way = astar_.plan(query, cost);
  Trust weighed = chosen;
  for (const Trust trust : {Trust::kSeen, Trust::kCertain}) {
    const bool is_off = trust == Trust::kCertain && params_.doubtful_certainty == 0;
    if (isShort(way) || trust == chosen || is_off) continue;
    weigh(trust, query.robot, before);
    weighed = trust;
    const Result other = astar_.plan(query, cost);
    if (!isWorse(way, other)) continue;
    way = other;
    chosen = trust;
  }
  if (weighed != chosen) weigh(chosen, query.robot, before);
  return way;
}

void CameraPlanner::search(const CameraObservation& observation, CameraPlan& plan) {
  planned_ = {observation.stamp, goal_->position(), plan.gap, nearObstacle(observation), false, false};
  const std::string halt = haltReason(observation.gap);
  const Path2 before = std::move(path_);
  path_.clear();
  plan.status = CameraPlan::Status::kHalted;
  plan.reason = halt;
  if (isLiteral() && !halt.empty()) return;
  const ModifiedAStar::Cost cost = costOf(observation);
  const ModifiedAStar::Query query{plan.robot.position(), goal_->position(), plan.gap,
                                   params_.goal_tolerance_m};
  const ModifiedAStar::Result found = isLiteral() ? astar_.plan(query, cost) : findWay(query, before, cost);
  if (found.status != ModifiedAStar::Result::Status::kFound) {
    if (halt.empty()) {
      plan.status = CameraPlan::Status::kNoPath;
      plan.reason = found.status == ModifiedAStar::Result::Status::kGoalBlocked
                        ? "the goal lies in an obstacle"
                        : "no way to the goal through what is seen and remembered";
    } else {
      plan.reason += ", and no other way is known";
    }
    return;
  }
  plan.reason.clear();
  planned_.reaches_goal = found.reaches_goal;
  planned_.through_gap = found.through_gap;
  std::vector<Eigen::Vector2d> corners = astar_.straighten(found.points, cost);
  if (corners.size() == 1) corners.push_back(corners.front());
  if (found.reaches_goal) corners.back() = goal_->position();
  path_ = resample(corners, params_.path_spacing_m, plan.robot.yaw_rad);
}

/// What lies ahead of the robot's place on its path.
Path2 CameraPlanner::rest(const Pose2& odom_from_base) const {
  if (path_.size() < 2) return path_;
  const Eigen::Vector2d p = odom_from_base.position();
  std::size_t at = 0;
  Eigen::Vector2d place = path_.front().position();
  double nearest_m = kInfinite;
  for (std::size_t i = 0; i + 1 < path_.size(); ++i) {
    const Eigen::Vector2d begin = path_[i].position();
    const Eigen::Vector2d way = path_[i + 1].position() - begin;
    const double f = std::clamp((p - begin).dot(way) / std::max(way.squaredNorm(), 1e-12), 0.0, 1.0);
    const double away_m = (p - begin - f * way).norm();
    if (away_m >= nearest_m) continue;
    nearest_m = away_m;
    at = i;
    place = begin + f * way;
  }
  Path2 ahead{{place.x(), place.y(), path_[at].yaw_rad}};
  ahead.insert(ahead.end(), path_.begin() + static_cast<std::ptrdiff_t>(at) + 1, path_.end());
  return ahead;
}

/// Ends the path where something that moves is to be let pass.
void CameraPlanner::giveWay(CameraPlan& plan) const {
  const double length_m = lengthOf(plan.path);
  const double free_m = lengthToYield(plan.path, plan.moving, body_.circumradius_m, params_.right_of_way);
  if (free_m >= length_m) return;
  plan.yields = true;
  plan.reaches_goal = false;
  Path2 kept;
  double s_m = 0.0;
  for (const Pose2& pose : plan.path) {
    if (!kept.empty()) s_m += distance(kept.back(), pose);
    if (s_m > free_m) break;
    kept.push_back(pose);
  }
  plan.path = kept;
  if (free_m >= kShortest_m && plan.path.size() > 1) return;
  plan.path.clear();
  plan.status = CameraPlan::Status::kHalted;
  plan.reason = "letting a moving obstacle pass";
}

}  // namespace frugal_nav
