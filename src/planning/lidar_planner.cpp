#include <cmath>
#include <vector>

#include <frugal_nav/planning/lidar_planner.hpp>
#include <frugal_nav/planning/path_shape.hpp>

namespace frugal_nav {
namespace {

std::string reasonOf(AStarResult::Status status) {
  return status == AStarResult::Status::kGoalBlocked
             ? "the goal lies in an obstacle"
             : "no way to the goal through what is seen and remembered";
}

}  // namespace

LidarPlanner::LidarPlanner(const LidarPlannerParams& params, const BodyExtent& body)
    : params_(params),
      body_(body),
      window_(params.grid, params.moving),
      cost_map_(params.cost, body, window_.grid(), params.tight_margin_m) {
  validate(params, "planner");
}

void LidarPlanner::setParams(const LidarPlannerParams& params) {
  validate(params, "planner");
  params_ = params;
  window_.setParams(params.grid, params.moving);
  cost_map_ = CostMap(params.cost, body_, grid(), params.tight_margin_m);
}

void LidarPlanner::setGoal(const std::optional<Pose2>& odom_from_goal) {
  const bool same = goal_ && odom_from_goal && distance(*goal_, *odom_from_goal) < params_.grid.cell_m;
  if (!same) previous_.clear();
  goal_ = odom_from_goal;
}

void LidarPlanner::reset() {
  window_.reset();
  previous_.clear();
}

LidarPlan LidarPlanner::update(const LaserScan& scan, const Pose2& base_from_laser,
                               const Pose2& odom_from_base) {
  LidarPlan result;
  result.stamp = scan.stamp;
  result.status = LidarPlan::Status::kStopped;
  if (const auto fault = findFault(scan)) {
    result.reason = *fault;
    return result;
  }
  if (!base_from_laser.isFinite()) {
    result.reason = "the laser's pose is not finite";
    return result;
  }
  if (!RollingGrid::holds(odom_from_base)) {
    result.reason = "the robot's pose is not finite, or farther off than 1000 km";
    return result;
  }
  window_.update(scan, odom_from_base * base_from_laser, odom_from_base.position());
  result.moving = window_.moving().moving();
  if (goal_ && !RollingGrid::holds(*goal_)) {
    result.reason = "the goal is not finite, or farther off than 1000 km";
    return result;
  }
  result.status = LidarPlan::Status::kIdle;
  if (goal_) plan(odom_from_base, result);
  previous_ = result.path;
  return result;
}

void LidarPlanner::plan(const Pose2& odom_from_base, LidarPlan& plan) {
  const Cell start = grid().cellOf(odom_from_base.position());
  const Cell goal = grid().cellOf(goal_->position());
  cost_map_.update(grid(), start);
  cost_map_.prefer(previous_, params_.same_way_m, params_.switch_gain);
  // Between two obstacles it may be tight; to stand beside one there has to be room.
  const Cell window_goal = cost_map_.toWindow(goal);
  if (cost_map_.weights().contains(window_goal) &&
      cost_map_.clearance_m(cost_map_.toWindow(start)) >= cost_map_.lethal_m())
    cost_map_.blockTight(window_goal, params_.goal_tolerance_m);
  const AStarResult found = search(odom_from_base.position(), goal);
  if (found.status != AStarResult::Status::kFound) {
    plan.status = LidarPlan::Status::kNoPath;
    plan.reason = reasonOf(found.status);
    return;
  }
  plan.status = LidarPlan::Status::kFound;
  plan.reaches_goal = found.cells.back() == cost_map_.toWindow(goal);
  plan.path = shape(found, odom_from_base, plan.reaches_goal);
}

/// The cheapest way; where it leads through a passage that is too narrow, that is closed and the next sought.
AStarResult LidarPlanner::search(const Eigen::Vector2d& p_odom_robot, Cell goal) {
  const Cell start = grid().cellOf(p_odom_robot);
  constexpr int kMostClosed = 8;
  for (int closed = 0;; ++closed) {
    AStarResult found =
        astar_.search(cost_map_.weights(), cost_map_.toWindow(start), cost_map_.toWindow(goal),
                      params_.goal_tolerance_m / params_.grid.cell_m);
    if (found.status != AStarResult::Status::kFound || findTightPassages(found.cells, p_odom_robot))
      return found;
    if (closed == kMostClosed) {
      found.status = AStarResult::Status::kNoPath;
      return found;
    }
  }
}

/// Measures the passages where a way is tight; false, with the place closed, when the body does not fit one.
bool LidarPlanner::findTightPassages(const std::vector<Cell>& cells, const Eigen::Vector2d& p_odom_robot) {
  passages_.clear();
  const double reach_m = 2.0 * cost_map_.lethal_m();
  for (const Cell cell : cells) {
    if (cost_map_.clearance_m(cell) >= cost_map_.lethal_m()) continue;
    const Eigen::Vector2d p = grid().centerOf({cell.x + cost_map_.origin().x, cell.y + cost_map_.origin().y});
    const auto passage = passageAt(p, window_.pointsWithin(p, reach_m), reach_m);
    if (!passage) continue;
    const double needed_m = 2.0 * body_.half_width_m + params_.passage_spare_m -
                            params_.passage_noise * (passage->middle_odom - p_odom_robot).norm();
    if (passage->width_m < needed_m) {
      cost_map_.block(cell, params_.grid.cell_m);
      return false;
    }
    const bool same = !passages_.empty() &&
                      (passages_.back().middle_odom - passage->middle_odom).norm() < params_.approach_m;
    if (!same) {
      passages_.push_back(*passage);
    } else if (passage->width_m < passages_.back().width_m) {
      passages_.back() = *passage;
    }
  }
  return true;
}

Path2 LidarPlanner::shape(const AStarResult& found, const Pose2& odom_from_base, bool at_goal) const {
  std::vector<Eigen::Vector2d> corners;
  for (const Cell cell : straighten(cost_map_.weights(), found.cells)) {
    corners.push_back(grid().centerOf({cell.x + cost_map_.origin().x, cell.y + cost_map_.origin().y}));
  }
  // The ends are places, not cells.
  if (corners.size() == 1) corners.push_back(corners.front());
  corners.front() = odom_from_base.position();
  if (at_goal) corners.back() = goal_->position();
  for (const TightPassage& passage : passages_) corners = leadThrough(corners, passage, params_.approach_m);
  return resample(corners, params_.path_spacing_m, odom_from_base.yaw_rad);
}

}  // namespace frugal_nav
