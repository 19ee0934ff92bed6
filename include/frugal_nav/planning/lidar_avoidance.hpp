#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/common/motion_command.hpp>
#include <frugal_nav/common/odometry.hpp>
#include <frugal_nav/common/params.hpp>
#include <frugal_nav/planning/body_extent.hpp>
#include <frugal_nav/planning/dynamic_window.hpp>
#include <frugal_nav/planning/local_planner.hpp>
#include <frugal_nav/planning/right_of_way.hpp>
#include <frugal_nav/planning/sector_avoidance.hpp>
#include <frugal_nav/planning/vfh_plus.hpp>

namespace frugal_nav {

struct LidarAvoidanceParams {
  std::string method = "vfh_star";
  bool use_path = true;
  double look_ahead_m = 0.8;
  double shortest_look_ahead_m = 0.3;
  double sight_margin_m = 0.08;
  double path_timeout_s = 0.5;
  SectorParams sectors;
  RollingGridParams window{6.0, 0.05, 4, 2, 12, 5.0, 4.0};
  MovingObstaclesParams moving;
  RightOfWayParams right_of_way{0.30, 5.0, 0.30, 0.30, 1.0, 1.5, 1.0, 0.6, 0.15};
  double company_m = 0.40;
  SpeedParams speed;
  VfhParams vfh;
  DynamicWindowParams dwa;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("method", method,
          Field{"", "how obstacles are avoided", -HUGE_VAL, HUGE_VAL, "sectors|vfh_plus|vfh_star|dwa"});
    visit("use_path", use_path,
          Field{"", "follow the planner's path; false: straight at the goal, as in the paper"});
    visit("look_ahead_m", look_ahead_m,
          Field{"m", "the target is the farthest point of the path within this that is in free sight", 0.1,
                5.0});
    visit("shortest_look_ahead_m", shortest_look_ahead_m,
          Field{"m", "the target where no farther point is in free sight: about the robot's length", 0.05,
                5.0});
    visit("sight_margin_m", sight_margin_m,
          Field{"m", "room beside the body along the line of sight", 0.0, 1.0});
    visit("path_timeout_s", path_timeout_s,
          Field{"s", "stop when the newest path is older than the scan by this", 0.05, 10.0});
    visit("sectors", sectors);
    visit("window", window);
    visit("moving", moving);
    visit("right_of_way", right_of_way);
    visit(
        "company_m", company_m,
        Field{
            "m",
            "it stands while something that came here a moment ago, and does not leave, is this near to its "
            "circle: way of a walker while the robot stops",
            0.0, 2.0});
    visit("speed", speed);
    visit("vfh", vfh);
    visit("dwa", dwa);
  }
  /// Names fields that contradict each other; empty when sound.
  std::string check() const {
    return shortest_look_ahead_m > look_ahead_m ? "shortest_look_ahead_m is above look_ahead_m" : "";
  }
};

/// Avoids what the scan shows on the way along a path, or straight to a goal.
class LidarAvoidance {
 public:
  LidarAvoidance(const LidarAvoidanceParams& params, const BodyExtent& body);

  /// Other parameters from the next scan on; goal and path stay. Throws ConfigError, and then nothing
  /// changes.
  void setParams(const LidarAvoidanceParams& params);

  /// Where it all leads, in odom; nothing: stand.
  void setGoal(const std::optional<Pose2>& odom_from_goal);

  /// The planner's path in odom, with the stamp of the scan it rests on; empty: the planner found none.
  void setPath(Stamp stamp, const Path2& path);

  /// The command for a scan; `odometry` is pose and twist at the scan's stamp. clear_bearing_rad is filled
  /// whenever the scan is sound.
  MotionCommand update(const LaserScan& scan, const Pose2& base_from_laser, const Odometry& odometry);

  /// Forgets the path and what earlier scans led to, but not the goal: after a jump in time.
  void reset();

  bool needsPath() const { return params_.use_path && goal_.has_value(); }
  std::optional<Stamp> pathStamp() const { return path_stamp_; }
  /// What the sector or a histogram method decided on the last scan, as directions around a robot that looks
  /// at `heading_rad` in odom; nothing for dwa, which weighs velocities.
  std::optional<SectorAvoidance::Decision> directions(double heading_rad) const;

 private:
  void makePlanner();
  std::string findPathFault(Stamp now) const;
  double freeWay(const Odometry& odometry, const Eigen::Vector2d& goal_odom, bool follows) const;
  bool hasCompany(const Eigen::Vector2d& p_odom_robot) const;
  Eigen::Vector2d lookAhead(const Pose2& odom_from_base,
                            const std::vector<Eigen::Vector2d>& obstacles_base) const;

  LidarAvoidanceParams params_;
  BodyExtent body_;
  std::unique_ptr<LocalPlanner> planner_;     ///< the chosen method
  const SectorAvoidance* sectors_ = nullptr;  ///< it, where it is that one
  const VfhPlus* vfh_ = nullptr;              ///< it, where it is VFH+ or VFH*
  std::unique_ptr<ActiveWindow> window_;
  std::optional<Pose2> goal_;
  std::optional<Stamp> path_stamp_;
  Path2 path_;
};

}  // namespace frugal_nav
