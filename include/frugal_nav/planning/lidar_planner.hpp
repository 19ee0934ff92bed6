#pragma once

#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/planning/active_window.hpp>
#include <frugal_nav/planning/astar.hpp>
#include <frugal_nav/planning/body_extent.hpp>
#include <frugal_nav/planning/cost_map.hpp>
#include <frugal_nav/planning/tight_passage.hpp>

namespace frugal_nav {

struct LidarPlannerParams {
  RollingGridParams grid;
  MovingObstaclesParams moving;
  CostMapParams cost;
  double goal_tolerance_m = 0.25;
  double switch_gain = 0.10;
  double same_way_m = 0.50;
  double path_spacing_m = 0.10;
  double tight_margin_m = -0.035;
  double passage_spare_m = 0.025;
  double passage_noise = 0.02;
  double approach_m = 0.50;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("grid", grid);
    visit("moving", moving);
    visit("cost", cost);
    visit("goal_tolerance_m", goal_tolerance_m,
          Field{"m",
                "a goal inside an obstacle is replaced by the nearest reachable place within this; below the "
                "mission's goal radius of 0.30",
                0.0, 2.0});
    visit("switch_gain", switch_gain,
          Field{"",
                "another way is taken when it is this part shorter than the present one: keeps the path from "
                "flipping between equal ways",
                0.0, 1.0});
    visit("same_way_m", same_way_m,
          Field{"m", "a path this near to the previous one is the same way, free to improve", 0.05, 5.0});
    visit("path_spacing_m", path_spacing_m, Field{"m", "distance between the points of the path", 0.02, 1.0});
    visit("tight_margin_m", tight_margin_m,
          Field{"m",
                "room beside the body's half width down to which the path goes where there is no other way; "
                "negative by what a cell's middle may be off, since the returns themselves measure passages",
                -0.2, 1.0});
    visit("passage_spare_m", passage_spare_m,
          Field{"m",
                "what a passage must be wider than the body: the collision stop's slow margin on both sides",
                0.0, 1.0});
    visit("passage_noise", passage_noise,
          Field{"",
                "and less by this share of its distance, twice a scan's noise: what looks too narrow from "
                "afar is "
                "looked at from near by",
                0.0, 0.2});
    visit("approach_m", approach_m,
          Field{"m", "before and behind a tight passage the path is straight for this long: a body's length",
                0.0, 3.0});
  }
};

/// What a scan led to.
struct LidarPlan {
  enum class Status {
    kIdle,     ///< no goal: nothing to plan
    kFound,    ///< `path` leads to the goal, or out of the window toward it
    kNoPath,   ///< the way is closed; `reason` says where
    kStopped,  ///< the scan or the pose cannot be used; `reason` says why
  };
  Stamp stamp{};  ///< of the scan
  Status status = Status::kIdle;
  std::string reason;
  Path2 path;  ///< in odom, from the robot on; empty: none
  bool reaches_goal =
      false;  ///< the path ends at the goal, not at the window's border or beside a blocked goal
  std::vector<TrackedObstacle> moving;  ///< what moves, in odom: the path does not lead around it
};

/// Plans on every scan: scan into the rolling grid, grid into weights, A*, straight lines.
class LidarPlanner {
 public:
  LidarPlanner(const LidarPlannerParams& params, const BodyExtent& body);

  /// Other parameters from the next scan on; what was seen stays, unless the grid's window or cells change.
  /// Throws ConfigError, and then nothing changes.
  void setParams(const LidarPlannerParams& params);

  /// Where to go, in odom; nothing: nowhere. A goal that is not finite gives kStopped.
  void setGoal(const std::optional<Pose2>& odom_from_goal);

  /// Takes a scan in and plans. `odom_from_base` is the pose at the scan's stamp.
  LidarPlan update(const LaserScan& scan, const Pose2& base_from_laser, const Pose2& odom_from_base);

  /// Forgets what was seen and planned, but not the goal: after a jump in time.
  void reset();

  const RollingGrid& grid() const { return window_.grid(); }
  const CostMap& costMap() const { return cost_map_; }

 private:
  void plan(const Pose2& odom_from_base, LidarPlan& plan);
  AStarResult search(const Eigen::Vector2d& p_odom_robot, Cell goal);
  bool findTightPassages(const std::vector<Cell>& cells, const Eigen::Vector2d& p_odom_robot);
  Path2 shape(const AStarResult& found, const Pose2& odom_from_base, bool at_goal) const;

  LidarPlannerParams params_;
  BodyExtent body_;
  ActiveWindow window_;
  CostMap cost_map_;
  AStar astar_;
  std::optional<Pose2> goal_;
  Path2 previous_;
  std::vector<TightPassage> passages_;  ///< on the way found last
};

}  // namespace frugal_nav
