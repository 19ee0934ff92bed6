#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/common/gap_sighting.hpp>
#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/nearest_obstacle.hpp>
#include <frugal_nav/common/odometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/common/time.hpp>
#include <frugal_nav/planning/body_extent.hpp>
#include <frugal_nav/planning/cost_map.hpp>
#include <frugal_nav/planning/modified_astar.hpp>
#include <frugal_nav/planning/obstacle_memory.hpp>
#include <frugal_nav/planning/right_of_way.hpp>

namespace frugal_nav {

/// When a new path is searched for.
struct ReplanParams {
  double obstacle_m = 1.2;
  double obstacle_moved_m = 0.15;
  double gap_moved_m = 0.30;
  double goal_moved_m = 0.10;
  double off_path_m = 0.15;
  double period_s = 1.0;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("obstacle_m", obstacle_m,
          Field{"m", "an obstacle that comes nearer than this; about three seconds ahead", 0.1, 10.0});
    visit("obstacle_moved_m", obstacle_moved_m,
          Field{"m", "or is there and turns out to be elsewhere by this much", 0.01, 5.0});
    visit("gap_moved_m", gap_moved_m,
          Field{"m", "a gap node farther than this from the one planned with is another gap", 0.01, 5.0});
    visit("goal_moved_m", goal_moved_m, Field{"m", "the goal has moved by this much", 0.01, 5.0});
    visit("off_path_m", off_path_m, Field{"m", "the robot is this far beside its path", 0.02, 5.0});
    visit("period_s", period_s, Field{"s", "and after this time in any case", 0.05, 60.0});
  }
};

struct CameraPlannerParams {
  ModifiedAStarParams astar;
  ObstacleMemoryParams memory;
  CostMapParams cost{0.015, 0.55, 4.0, 5.0};
  ReplanParams replan;
  RightOfWayParams right_of_way;
  double halt_width_factor = 2.0;
  double width_slack_m = 0.05;
  double assumed_depth_m = 0.40;
  double far_side_detour = 2.0;
  int doubtful_certainty = 12;
  double doubtful_from_m = 0.8;
  double goal_tolerance_m = 0.25;
  double switch_gain = 0.15;
  double same_way_m = 0.35;
  double path_spacing_m = 0.10;

  CameraPlannerParams() { astar.cell_m = 0.05; }

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("astar", astar);
    visit("memory", memory);
    visit("cost", cost);
    visit("replan", replan);
    visit("right_of_way", right_of_way);
    visit("halt_width_factor", halt_width_factor,
          Field{"",
                "a gap narrower than this many robot widths is not driven through [paper]; 1.5 is the stress "
                "setting",
                1.0, 5.0});
    visit("width_slack_m", width_slack_m,
          Field{"m", "by which the memory may show a gap narrower than it is: a cell", 0.0, 0.5});
    visit("assumed_depth_m", assumed_depth_m,
          Field{"m",
                "cells never seen this near to an obstacle are taken for its far side, unless there is no "
                "other way, or none but a long one; 0: never",
                0.0, 2.0});
    visit(
        "far_side_detour", far_side_detour,
        Field{"",
              "a way around such cells, or around what is doubtful, that costs this many times the way past "
              "them is too long: it mostly leads where nothing was seen yet",
              1.0, 100.0});
    visit("doubtful_certainty", doubtful_certainty,
          Field{"",
                "obstacles in the memory no more certain than this are looked at from near by where there is "
                "no other way, or none but a long one; 0: never",
                0, 120});
    visit("doubtful_from_m", doubtful_from_m,
          Field{"m", "nearer than this they count like all others", 0.0, 10.0});
    visit("goal_tolerance_m", goal_tolerance_m,
          Field{"m",
                "a goal beside an obstacle is replaced by the nearest reachable place within this; below the "
                "mission's goal radius of 0.30",
                0.0, 2.0});
    visit("switch_gain", switch_gain,
          Field{"", "another way is taken when it is this part cheaper than the present one", 0.0, 1.0});
    visit("same_way_m", same_way_m,
          Field{"m", "a path this near to the previous one is the same way, free to improve", 0.05, 5.0});
    visit("path_spacing_m", path_spacing_m, Field{"m", "distance between the points of the path", 0.02, 1.0});
  }
  /// Names fields that contradict each other; empty when sound.
  std::string check() const {
    if (doubtful_certainty >= memory.grid.max_certainty)
      return "doubtful_certainty must be below memory/grid/max_certainty, or all is doubtful";
    return "";
  }
};

/// What one image shows, and where the robot was when it was taken.
struct CameraObservation {
  Stamp stamp{};  ///< of the image
  GapSighting gap;
  NearestObstacle obstacle;
  LaserScan scan;     ///< in base_link: the nearest surface in each bearing of the view
  Odometry odometry;  ///< at the image's stamp
  std::string fault;  ///< why none of it can be used; empty: it can
};

/// What an image led to.
struct CameraPlan {
  enum class Status {
    kIdle,     ///< no goal: nothing to plan
    kFound,    ///< `path` leads to the goal, or to where something that moves is let pass
    kNoPath,   ///< the way is closed
    kHalted,   ///< no gap, one too narrow, or something that moves is let pass at once
    kStopped,  ///< the observation cannot be used
  };
  Stamp stamp{};  ///< of the image
  Status status = Status::kIdle;
  std::string reason;  ///< of all but kIdle and kFound
  Path2 path;          ///< in odom; empty: stand
  bool reaches_goal = false;
  bool yields = false;       ///< the path ends where something that moves is let pass
  bool through_gap = false;  ///< it leads through the gap node
  std::string replanned;     ///< why a new path was searched for; empty: the one before still holds

  // The nodes of the instantaneous grid, in odom.
  Pose2 robot;
  std::optional<Eigen::Vector2d> gap;
  std::optional<NearestObstacle> obstacle;
  std::vector<TrackedObstacle> moving;
};

/// Plans from what a camera sees: the modified A* over the instantaneous grid and a short memory of what has
/// left the view.
class CameraPlanner {
 public:
  /// Throws ConfigError on parameters out of range.
  CameraPlanner(const CameraPlannerParams& params, const BodyExtent& body);

  /// Other parameters from the next image on; what was seen stays, unless the memory's window or cells
  /// change. Throws ConfigError, and then nothing changes.
  void setParams(const CameraPlannerParams& params);

  /// Where to go, in odom, and the person standing there, who is no obstacle; nothing: nowhere. A goal that
  /// follows one is the same mission's, which has moved.
  void setGoal(const std::optional<Pose2>& odom_from_goal,
               const std::optional<Eigen::Vector2d>& p_odom_person = std::nullopt);

  /// Takes in what an image shows and plans.
  CameraPlan update(const CameraObservation& observation);

  /// Forgets what was seen and planned, but not the goal: after a jump in time.
  void reset();

  const ObstacleMemory& memory() const { return memory_; }
  const CostMap& costMap() const { return cost_map_; }
  const CameraPlannerParams& params() const { return params_; }

 private:
  struct Planned {  ///< what the present path was made from
    Stamp stamp{};
    Eigen::Vector2d goal = Eigen::Vector2d::Zero();
    std::optional<Eigen::Vector2d> gap;
    std::optional<Eigen::Vector2d> near_obstacle;
    bool reaches_goal = false;
    bool through_gap = false;
  };

  /// What of the memory a way is searched with.
  enum class Trust {
    kFarSides,  ///< all that is seen, and unseen far sides behind it
    kSeen,      ///< all that is seen
    kCertain,   ///< only what is certain or near
  };

  bool isLiteral() const { return params_.astar.mode == "literal"; }
  std::string findFault(const CameraObservation& observation) const;
  bool isNarrow(const GapSighting& gap) const;
  double keepOffPerson_m(const Eigen::Vector2d& p_odom_robot) const;
  std::string haltReason(const GapSighting& gap) const;
  std::optional<Eigen::Vector2d> gapNode(const GapSighting& gap) const;
  std::optional<Eigen::Vector2d> nearObstacle(const CameraObservation& observation) const;
  std::string replanReason(const CameraObservation& observation) const;
  bool isClosed(const Path2& path) const;
  ModifiedAStar::Cost costOf(const CameraObservation& observation) const;
  void weigh(Trust trust, const Eigen::Vector2d& p_odom_robot, const Path2& before);
  ModifiedAStar::Result findWay(const ModifiedAStar::Query& query, const Path2& before,
                                const ModifiedAStar::Cost& cost);
  void search(const CameraObservation& observation, CameraPlan& plan);
  void giveWay(CameraPlan& plan) const;
  Path2 rest(const Pose2& odom_from_base) const;

  CameraPlannerParams params_;
  BodyExtent body_;
  ObstacleMemory memory_;
  CostMap cost_map_;
  ModifiedAStar astar_;
  std::optional<Pose2> goal_;
  std::optional<Eigen::Vector2d> p_odom_person_;
  bool mission_started_ = false;
  Path2 path_;
  Planned planned_;
};

}  // namespace frugal_nav
