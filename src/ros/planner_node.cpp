#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Path.h>

#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/parameters.hpp>
#include <frugal_nav/ros/planner_node.hpp>
#include <frugal_nav/ros/planning_markers.hpp>

namespace frugal_nav {
namespace {

PlannerNodeParams load(const ros::NodeHandle& pnh) {
  PlannerNodeParams params;
  loadParameters(pnh, params);
  return params;
}

}  // namespace

PlannerNode::PlannerNode(ros::NodeHandle nh, ros::NodeHandle pnh)
    : params_(load(pnh)),
      body_(extentOf(loadRobotDescription(nh, params_.intake.base_frame))),
      planner_(params_.planner, body_),
      diagnostics_(nh, pnh),
      reason_(nh) {
  path_pub_ = nh.advertise<nav_msgs::Path>("path", 5);
  grid_pub_ = nh.advertise<nav_msgs::OccupancyGrid>("grid", 1);
  markers_pub_ = nh.advertise<visualization_msgs::MarkerArray>("planner/markers", 1);
  intake_ =
      std::make_unique<ScanIntake>(nh, params_.intake, params_.scan, diagnostics_,
                                   ScanIntake::Callbacks{[](const PosedScan&) { return true; },
                                                         [this](const PosedScan& posed) { process(posed); },
                                                         [this] {
                                                           planner_.reset();
                                                           last_grid_ = ros::Time();
                                                         }});
  live_ = tuneLive<PlannerNodeParams>(pnh, params_, [this](const PlannerNodeParams& wanted) {
    params_.planner = wanted.planner;
    params_.grid_period_s = wanted.grid_period_s;
    planner_.setParams(params_.planner);
    intake_->setRules(wanted.scan);
  });
}

void PlannerNode::process(const PosedScan& posed) {
  LidarPlan plan;
  plan.stamp = posed.scan.stamp;
  plan.status = LidarPlan::Status::kStopped;
  plan.reason = posed.fault;
  if (posed.fault.empty()) {
    planner_.setGoal(intake_->goal());
    const ros::WallTime start = ros::WallTime::now();
    plan = planner_.update(posed.scan, posed.base_from_laser, posed.odometry.odom_from_base);
    diagnostics_.set("time of a plan [ms]", (ros::WallTime::now() - start).toSec() * 1e3);
  }
  path_pub_.publish(toRos(plan.path, plan.stamp, params_.intake.odom_frame));
  report(plan);
  if (markers_pub_.getNumSubscribers() > 0) {
    markers_pub_.publish(
        planMarkers(plan, intake_->goal(), params_.planner.goal_tolerance_m, params_.intake.odom_frame));
  }
  publishGrid(toRos(plan.stamp));
}

void PlannerNode::report(const LidarPlan& plan) {
  using diagnostic_msgs::DiagnosticStatus;
  reason_.tell(plan.path.empty() ? plan.reason : "");
  switch (plan.status) {
    case LidarPlan::Status::kIdle:
      diagnostics_.status(DiagnosticStatus::OK, "no goal");
      return;
    case LidarPlan::Status::kFound:
      diagnostics_.status(DiagnosticStatus::OK,
                          plan.reaches_goal ? "path to the goal" : "path toward the goal");
      return;
    case LidarPlan::Status::kNoPath:
    case LidarPlan::Status::kStopped:
      diagnostics_.status(DiagnosticStatus::WARN, plan.reason);
      ROS_WARN_THROTTLE(5.0, "no path: %s", plan.reason.c_str());
      return;
  }
}

void PlannerNode::publishGrid(ros::Time stamp) {
  if (grid_pub_.getNumSubscribers() == 0) return;
  if (!last_grid_.isZero() && (stamp - last_grid_).toSec() < params_.grid_period_s) return;
  last_grid_ = stamp;
  grid_pub_.publish(gridMessage(planner_.grid(), stamp, params_.intake.odom_frame));
}

}  // namespace frugal_nav
