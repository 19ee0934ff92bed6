#include <cmath>

#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Path.h>

#include <frugal_nav/ros/camera_markers.hpp>
#include <frugal_nav/ros/camera_planner_node.hpp>
#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/parameters.hpp>
#include <frugal_nav/ros/planning_markers.hpp>

namespace frugal_nav {
namespace {

constexpr double kCheckPeriod_s = 0.05;

CameraPlannerNodeParams load(const ros::NodeHandle& pnh) {
  CameraPlannerNodeParams params;
  loadParameters(pnh, params);
  return params;
}

}  // namespace

CameraPlannerNode::CameraPlannerNode(ros::NodeHandle nh, ros::NodeHandle pnh)
    : params_(load(pnh)),
      planner_(params_.planner, extentOf(loadRobotDescription(nh))),
      diagnostics_(nh, pnh),
      reason_(nh),
      time_([this](Stamp now) { forget(now); }),
      goal_(nh, params_.intake.odom_frame, Mode::kCamera, diagnostics_, time_) {
  path_pub_ = nh.advertise<nav_msgs::Path>("path", 5);
  grid_pub_ = nh.advertise<nav_msgs::OccupancyGrid>("grid", 1);
  markers_pub_ = nh.advertise<visualization_msgs::MarkerArray>("planner/markers", 1);
  diagnostics_.input("goal/observed");
  observed_sub_ = nh.subscribe("goal/observed", 1, &CameraPlannerNode::onObserved, this,
                               ros::TransportHints().tcpNoDelay());
  intake_ =
      std::make_unique<CameraIntake>(nh, params_.intake, params_.input_wait_s, diagnostics_, time_,
                                     [this](const CameraObservation& observation) { process(observation); });
  timer_ = nh.createTimer(ros::Duration(kCheckPeriod_s), [this](const ros::TimerEvent&) {
    time_.checkClock();
    intake_->process();
  });
  live_ = tuneLive<CameraPlannerNodeParams>(pnh, params_, [this](const CameraPlannerNodeParams& wanted) {
    planner_.setParams(wanted.planner);
    params_ = wanted;
  });
}

void CameraPlannerNode::forget(Stamp now) {
  planner_.reset();
  goal_.forget(now);
  p_odom_person_.reset();
  last_grid_ = ros::Time();
  if (intake_) intake_->clear();
}

void CameraPlannerNode::onObserved(const geometry_msgs::PoseWithCovarianceStamped& msg) {
  const geometry_msgs::Point& p = msg.pose.pose.position;
  if (msg.header.frame_id != params_.intake.odom_frame || !std::isfinite(p.x) || !std::isfinite(p.y)) {
    diagnostics_.input("goal/observed").refused("not finite, or not in " + params_.intake.odom_frame);
    return;
  }
  time_.checkStamp("goal/observed", toStamp(msg.header.stamp));
  diagnostics_.input("goal/observed").received(toStamp(msg.header.stamp), toStamp(ros::Time::now()));
  p_odom_person_ = Eigen::Vector2d(p.x, p.y);
  person_seen_ = toStamp(msg.header.stamp);
}

/// The person who is the goal: one who was seen where the goal leads to.
std::optional<Eigen::Vector2d> CameraPlannerNode::personAt(const std::optional<Pose2>& odom_from_goal,
                                                           Stamp now) const {
  if (!odom_from_goal || !p_odom_person_) return std::nullopt;
  if (toSeconds(now - person_seen_) > params_.person_memory_s) return std::nullopt;
  const double away_m = (odom_from_goal->position() - *p_odom_person_).norm();
  return away_m <= params_.person_near_goal_m ? p_odom_person_ : std::nullopt;
}

void CameraPlannerNode::process(const CameraObservation& observation) {
  const std::optional<Pose2> goal = goal_.goal();
  planner_.setGoal(goal, personAt(goal, observation.stamp));
  const ros::WallTime start = ros::WallTime::now();
  const CameraPlan plan = planner_.update(observation);
  diagnostics_.set("time of a plan [ms]", (ros::WallTime::now() - start).toSec() * 1e3);
  path_pub_.publish(toRos(plan.path, plan.stamp, params_.intake.odom_frame));
  report(plan);
  show(plan);
}

void CameraPlannerNode::report(const CameraPlan& plan) {
  using diagnostic_msgs::DiagnosticStatus;
  diagnostics_.set("moving obstacles", static_cast<double>(plan.moving.size()));
  if (!plan.replanned.empty()) diagnostics_.set("last search", plan.replanned);
  reason_.tell(plan.path.empty() ? plan.reason : "");
  switch (plan.status) {
    case CameraPlan::Status::kIdle:
      diagnostics_.status(DiagnosticStatus::OK, "no goal");
      return;
    case CameraPlan::Status::kFound:
      diagnostics_.status(DiagnosticStatus::OK, plan.yields         ? "path to where something moving passes"
                                                : plan.through_gap  ? "path to the goal through the gap"
                                                : plan.reaches_goal ? "path to the goal"
                                                                    : "path toward the goal");
      return;
    case CameraPlan::Status::kNoPath:
    case CameraPlan::Status::kHalted:
    case CameraPlan::Status::kStopped:
      diagnostics_.status(DiagnosticStatus::WARN, plan.reason);
      ROS_WARN_THROTTLE(5.0, "no path: %s", plan.reason.c_str());
      return;
  }
}

void CameraPlannerNode::show(const CameraPlan& plan) {
  if (markers_pub_.getNumSubscribers() > 0)
    markers_pub_.publish(cameraPlanMarkers(plan, goal_.goal(), params_.intake.odom_frame));
  if (grid_pub_.getNumSubscribers() == 0) return;
  const ros::Time stamp = toRos(plan.stamp);
  if (!last_grid_.isZero() && (stamp - last_grid_).toSec() < params_.grid_period_s) return;
  last_grid_ = stamp;
  grid_pub_.publish(gridMessage(planner_.memory().grid(), stamp, params_.intake.odom_frame));
}

}  // namespace frugal_nav
