#include <algorithm>
#include <cmath>
#include <cstdio>

#include <frugal_nav/planning/corridor.hpp>
#include <frugal_nav/planning/lidar_avoidance.hpp>
#include <frugal_nav/planning/path_shape.hpp>
#include <frugal_nav/planning/vfh_star.hpp>

namespace frugal_nav {
namespace {

// A way shorter than this is not worth starting.
constexpr double kShortest_m = 0.08;
// A single return may be noise.
constexpr int kLeastReturns = 2;

MotionCommand stopped(MotionCommand command, MotionCommand::Status status, const std::string& reason) {
  command.status = status;
  command.reason = reason;
  command.holds = MotionCommand::Holds::kNothing;
  command.velocity = {};
  return command;
}

std::string seconds(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f s", value);
  return text;
}

/// Index of the path's point nearest to a place.
std::size_t nearestIndex(const Path2& path, const Eigen::Vector2d& p) {
  const auto nearest = std::min_element(path.begin(), path.end(), [&p](const Pose2& a, const Pose2& b) {
    return (a.position() - p).squaredNorm() < (b.position() - p).squaredNorm();
  });
  return static_cast<std::size_t>(nearest - path.begin());
}

}  // namespace

LidarAvoidance::LidarAvoidance(const LidarAvoidanceParams& params, const BodyExtent& body) : body_(body) {
  setParams(params);
}

void LidarAvoidance::setParams(const LidarAvoidanceParams& params) {
  validate(params, "avoidance");
  params_ = params;
  makePlanner();
  if (window_)
    window_->setParams(params.window, params.moving);
  else
    window_ = std::make_unique<ActiveWindow>(params.window, params.moving);
}

void LidarAvoidance::makePlanner() {
  sectors_ = nullptr;
  vfh_ = nullptr;
  const auto take = [this](auto planner) {
    const auto* made = planner.get();
    planner_ = std::move(planner);
    return made;
  };
  if (params_.method == "vfh_star") {
    vfh_ = take(std::make_unique<VfhStar>(params_.vfh, params_.speed, body_));
  } else if (params_.method == "vfh_plus") {
    vfh_ = take(std::make_unique<VfhPlus>(params_.vfh, params_.speed, body_));
  } else if (params_.method == "dwa") {
    take(std::make_unique<DynamicWindow>(params_.dwa, params_.speed, body_));
  } else {
    sectors_ = take(std::make_unique<SectorAvoidance>(params_.sectors, body_));
  }
}

void LidarAvoidance::setGoal(const std::optional<Pose2>& odom_from_goal) {
  const bool same = goal_ && odom_from_goal && distance(*goal_, *odom_from_goal) < 1e-6;
  if (!same) planner_->reset();
  goal_ = odom_from_goal;
}

void LidarAvoidance::setPath(Stamp stamp, const Path2& path) {
  path_stamp_ = stamp;
  path_ = path;
}

void LidarAvoidance::reset() {
  path_stamp_.reset();
  path_.clear();
  window_->reset();
  planner_->reset();
}

MotionCommand LidarAvoidance::update(const LaserScan& scan, const Pose2& base_from_laser,
                                     const Odometry& odometry) {
  using Status = MotionCommand::Status;
  MotionCommand idle;
  idle.stamp = scan.stamp;
  if (const auto fault = findFault(scan)) return stopped(idle, Status::kStopped, *fault);
  if (!base_from_laser.isFinite()) return stopped(idle, Status::kStopped, "the laser's pose is not finite");
  if (!RollingGrid::holds(odometry.odom_from_base) || !odometry.twist.isFinite())
    return stopped(idle, Status::kStopped, "the odometry is not finite, or farther off than 1000 km");
  if (goal_ && !RollingGrid::holds(*goal_))
    return stopped(idle, Status::kStopped, "the goal is not finite, or farther off than 1000 km");

  if (sectors_ == nullptr)  // which decides on the scan alone
    window_->update(scan, odometry.odom_from_base * base_from_laser, odometry.odom_from_base.position());
  const std::vector<Eigen::Vector2d> obstacles = obstaclePoints(scan, base_from_laser);
  const std::string path_fault = needsPath() ? findPathFault(scan.stamp) : "";
  const bool follows = needsPath() && path_fault.empty() && !path_.empty();
  const Eigen::Vector2d ahead = odometry.odom_from_base * Eigen::Vector2d(1.0, 0.0);
  const Eigen::Vector2d goal = goal_ ? goal_->position() : ahead;
  const Eigen::Vector2d target = follows ? lookAhead(odometry.odom_from_base, obstacles) : goal;
  // The method sees every scan, so that the clearer side is known while the robot stands.
  const double way_m = freeWay(odometry, goal, follows);
  const MotionCommand command =
      planner_->plan({scan, base_from_laser, obstacles, odometry, target, goal, window_.get(), way_m});
  if (!goal_) return stopped(command, Status::kIdle, "no goal");
  if (!path_fault.empty()) return stopped(command, Status::kStopped, path_fault);
  if (needsPath() && path_.empty())
    return stopped(command, Status::kBlocked, "the planner has no path to the goal");
  if (way_m < kShortest_m || hasCompany(odometry.odom_from_base.position()))
    return stopped(command, Status::kDriving, "letting a moving obstacle pass");
  return command;
}

std::optional<SectorAvoidance::Decision> LidarAvoidance::directions(double heading_rad) const {
  if (sectors_ != nullptr) return sectors_->decision();
  if (vfh_ == nullptr) return std::nullopt;
  const VfhPlus::Decision& decision = vfh_->decision();
  SectorAvoidance::Decision shown{SectorRing(decision.masked.size())};
  for (int i = 0; i < shown.ring.size(); ++i) {
    const double bearing_odom_rad = wrapAngle(heading_rad + shown.ring.bearingOf(i));
    if (!decision.masked.isFree(decision.masked.sectorOf(bearing_odom_rad))) shown.ring.block(i);
  }
  for (const double candidate_odom_rad : decision.candidates_odom_rad)
    shown.candidates_rad.push_back(angleBetween(heading_rad, candidate_odom_rad));
  shown.found = decision.chosen_odom_rad.has_value();
  shown.bearing_rad = angleBetween(heading_rad, decision.chosen_odom_rad.value_or(heading_rad));
  return shown;
}

std::string LidarAvoidance::findPathFault(Stamp now) const {
  if (!path_stamp_) return "no path from the planner yet";
  const double age = toSeconds(now - *path_stamp_);
  if (age > params_.path_timeout_s) return "no path from the planner for " + seconds(age);
  const bool finite = std::all_of(path_.begin(), path_.end(), [](const Pose2& p) { return p.isFinite(); });
  return finite ? "" : "the path is not finite";
}

/// How far the robot may drive without getting in the way of what moves [m].
double LidarAvoidance::freeWay(const Odometry& odometry, const Eigen::Vector2d& goal_odom,
                               bool follows) const {
  if (sectors_ != nullptr || window_->moving().moving().empty()) return HUGE_VAL;
  const Eigen::Vector2d p_odom_robot = odometry.odom_from_base.position();
  Path2 ahead{{p_odom_robot.x(), p_odom_robot.y(), 0.0}};
  if (follows)
    ahead.insert(ahead.end(), path_.begin() + static_cast<std::ptrdiff_t>(nearestIndex(path_, p_odom_robot)),
                 path_.end());
  else
    ahead.push_back({goal_odom.x(), goal_odom.y(), 0.0});
  const double free_m = lengthToYield(ahead, window_->moving().moving(), body_.circumradius_m,
                                      params_.right_of_way, std::max(odometry.twist.v_mps, 0.0));
  return free_m < lengthOf(ahead) ? free_m : HUGE_VAL;
}

/// Whether something that moves is close by, and not on its way off.
bool LidarAvoidance::hasCompany(const Eigen::Vector2d& p_odom_robot) const {
  if (sectors_ != nullptr) return false;
  const MovingObstacles& moving = window_->moving();
  const double near_m = body_.circumradius_m + params_.company_m;
  return std::count_if(moving.newcomers().begin(), moving.newcomers().end(), [&](const Eigen::Vector2d& p) {
           return (p - p_odom_robot).norm() < near_m && !moving.isLeaving(p, p_odom_robot);
         }) >= kLeastReturns;
}

/// The farthest point of the path within look_ahead_m, measured along it, that a body's width can reach
/// straight; where none is in sight, the point shortest_look_ahead_m along.
Eigen::Vector2d LidarAvoidance::lookAhead(const Pose2& odom_from_base,
                                          const std::vector<Eigen::Vector2d>& obstacles_base) const {
  const Pose2 base_from_odom = odom_from_base.inverse();
  const std::size_t nearest = nearestIndex(path_, odom_from_base.position());
  Eigen::Vector2d target = path_[nearest].position();
  double along = 0.0;
  for (std::size_t i = nearest + 1; i < path_.size(); ++i) {
    along += distance(path_[i - 1], path_[i]);
    if (along > params_.look_ahead_m + 1e-9) break;
    const Eigen::Vector2d p = path_[i].position();
    const Corridor sight{base_from_odom * p, body_.half_width_m + params_.sight_margin_m, body_.half_width_m};
    if (along <= params_.shortest_look_ahead_m || isFree(sight, obstacles_base)) target = p;
  }
  return target;
}

}  // namespace frugal_nav
