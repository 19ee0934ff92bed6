#include <algorithm>
#include <cmath>

#include <tf2_geometry_msgs/tf2_geometry_msgs.h>

#include <frugal_nav/MissionState.h>
#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/mission_node.hpp>
#include <frugal_nav/ros/parameters.hpp>

namespace frugal_nav {
namespace {

constexpr double kCheckPeriod_s = 0.1;

MissionNodeParams loadMissionParams(const ros::NodeHandle& pnh) {
  MissionNodeParams params;
  loadParameters(pnh, params);
  return params;
}

// Why no pose can be made of a message; empty when one can.
std::string poseFault(const geometry_msgs::Pose& pose) {
  const auto& p = pose.position;
  const auto& q = pose.orientation;
  const double length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(length)) return "goal is not finite";
  if (length == 0.0) return "goal has a zero quaternion: no heading; for yaw 0 set w to 1";
  if (!yawOf(q)) return "goal has a quaternion of length " + std::to_string(length) + " instead of 1";
  return "";
}

std::string withoutSlash(const std::string& frame) {
  return !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
}

}  // namespace

MissionNode::MissionNode(ros::NodeHandle nh, ros::NodeHandle pnh)
    : params_(loadMissionParams(pnh)),
      mission_(params_.mission),
      diagnostics_(nh, pnh),
      tf_listener_(tf_buffer_),
      server_(
          nh, "move_base", [this](GoalHandle handle) { onGoal(handle); },
          [this](GoalHandle handle) { onCancel(handle); }, false) {
  if (!params_.waypoints_file.empty()) tour_ = readWaypoints(params_.waypoints_file);
  goal_pub_ = nh.advertise<geometry_msgs::PoseStamped>("mission/goal", 1, true);
  state_pub_ = nh.advertise<MissionState>("mission/state", 10, true);
  command_pub_ = nh.advertise<geometry_msgs::TwistStamped>("mission/command", 10);
  action_goal_pub_ = nh.advertise<move_base_msgs::MoveBaseActionGoal>("move_base/goal", 1);
  for (const char* topic : {"odom", "path", "avoidance/command"}) diagnostics_.input(topic);
  // Small messages in a control loop: Nagle's algorithm would hold them back for tens of milliseconds.
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  odometry_sub_ = nh.subscribe("odom", 10, &MissionNode::onOdometry, this, hints);
  path_reason_sub_ = nh.subscribe<std_msgs::String>(
      "path/reason", 2, [this](const std_msgs::StringConstPtr& msg) { path_reason_ = msg->data; },
      ros::VoidConstPtr(), hints);
  path_sub_ = nh.subscribe("path", 2, &MissionNode::onPath, this, hints);
  command_sub_ = nh.subscribe("avoidance/command", 2, &MissionNode::onLocalCommand, this, hints);
  observed_sub_ = nh.subscribe("goal/observed", 1, &MissionNode::onObserved, this, hints);
  base_command_sub_ = nh.subscribe("cmd_vel_stamped", 10, &MissionNode::onBaseCommand, this, hints);
  simple_goal_sub_ = nh.subscribe("move_base_simple/goal", 1, &MissionNode::onSimpleGoal, this);
  cancel_sub_ = nh.subscribe("move_base/cancel", 5, &MissionNode::onCancelAll, this);
  manual_service_ = pnh.advertiseService("set_manual", &MissionNode::onSetManual, this);
  timer_ = nh.createTimer(ros::Duration(kCheckPeriod_s), [this](const ros::TimerEvent&) { onTimer(); });
  tuning_ = tuneLive<MissionNodeParams>(pnh, params_, [this](const MissionNodeParams& wanted) {
    mission_.setParams(wanted.mission);
    params_.feedback_rate_hz = wanted.feedback_rate_hz;
    params_.map_timeout_s = wanted.map_timeout_s;
  });
  server_.start();
  publishStatus();
}

void MissionNode::onGoal(GoalHandle handle) {
  // No older than the state before it, though the clock may come later than odometry: by the stamps others
  // tell whether a state speaks of this goal.
  const ros::Time now = std::max(checkClock(), toRos(mission_.status().stamp));
  const geometry_msgs::PoseStamped& target = handle.getGoal()->target_pose;
  const std::variant<Pose2, std::string> goal = toOdom(target);
  const bool of_tour = tour_ && handle.getGoalID().id == tour_goal_id_;
  mission_.cancel("preempted by a new goal");
  reportEnds();
  handle.setAccepted();
  goal_handle_ = handle;
  map_goal_.reset();
  if (const auto* odom_from_goal = std::get_if<Pose2>(&goal)) {
    if (withoutSlash(target.header.frame_id) == params_.map_frame) map_goal_ = target;
    const bool with_yaw = !of_tour || tour_->waypoints[next_waypoint_].yaw_rad.has_value();
    mission_.setGoal(*odom_from_goal, toStamp(now), with_yaw);
  } else {
    mission_.refuseGoal(std::get<std::string>(goal), toStamp(now));
  }
  if (mission_.active()) {
    publishGoal(now);
    ROS_INFO("goal %u: (%.2f, %.2f) in %s", mission_.status().goal_number, mission_.goal().x_m,
             mission_.goal().y_m, params_.odom_frame.c_str());
  }
  publishStatus();
  reportEnds();
}

void MissionNode::onCancel(GoalHandle handle) {
  if (!goal_handle_ || *goal_handle_ != handle) return;
  mission_.cancel();
  publishStatus();
  reportEnds();
}

/// The action server knows only goals that came by it: "cancel all" ends following and searching too.
void MissionNode::onCancelAll(const GoalId& id) {
  if (!id.id.empty() || goal_handle_) return;
  mission_.cancel();
  publishStatus();
  reportEnds();
}

void MissionNode::onSimpleGoal(const geometry_msgs::PoseStamped& goal) {
  move_base_msgs::MoveBaseActionGoal action;
  action.header.stamp = ros::Time::now();
  action.goal.target_pose = goal;
  action_goal_pub_.publish(action);
}

void MissionNode::onObserved(const geometry_msgs::PoseWithCovarianceStamped& msg) {
  geometry_msgs::PoseStamped seen;
  seen.header = msg.header;
  seen.pose.position = msg.pose.pose.position;
  seen.pose.orientation.w = 1.0;  // which way the person looks does not matter
  const std::variant<Pose2, std::string> place = toOdom(seen);
  if (const auto* fault = std::get_if<std::string>(&place)) {
    diagnostics_.input("goal/observed").refused(*fault);
    return;
  }
  const ros::Time now = std::max(checkClock(), toRos(mission_.status().stamp));
  diagnostics_.input("goal/observed").received(toStamp(msg.header.stamp), toStamp(now));
  const std::uint32_t goal_number = mission_.status().goal_number;
  mission_.setObservedGoal(std::get<Pose2>(place).position(), toStamp(now));
  if (mission_.active() && mission_.goalChanges() != goal_changes_) publishGoal(now);
  if (mission_.status().goal_number == goal_number) return;
  ROS_INFO("goal %u: the person at (%.2f, %.2f) in %s", mission_.status().goal_number,
           std::get<Pose2>(place).x_m, std::get<Pose2>(place).y_m, params_.odom_frame.c_str());
  publishStatus();
}

void MissionNode::onBaseCommand(const geometry_msgs::TwistStamped& msg) {
  const Twist2 velocity = planar(msg.twist);
  if (!velocity.isFinite()) {
    diagnostics_.input("cmd_vel_stamped").refused("not finite");
    return;
  }
  diagnostics_.input("cmd_vel_stamped").received(toStamp(msg.header.stamp), toStamp(checkClock()));
  mission_.setBaseCommand(velocity, toStamp(msg.header.stamp));
}

void MissionNode::publishGoal(ros::Time now) {
  goal_changes_ = mission_.goalChanges();
  geometry_msgs::PoseStamped msg;
  msg.header.stamp = now;
  msg.header.frame_id = params_.odom_frame;
  msg.pose = toRos(mission_.goal());
  goal_pub_.publish(msg);
}

std::variant<Pose2, std::string> MissionNode::toOdom(const geometry_msgs::PoseStamped& goal) const {
  const std::string fault = poseFault(goal.pose);
  if (!fault.empty()) return fault;
  const std::string frame = withoutSlash(goal.header.frame_id);
  if (frame == params_.odom_frame) return planar(goal.pose).value();
  if (frame.empty()) return "goal in an unknown frame: its frame_id is empty";
  try {
    // The newest transform: the goal's own stamp may lie before the listener's start.
    const geometry_msgs::TransformStamped transform =
        tf_buffer_.lookupTransform(params_.odom_frame, frame, ros::Time(0));
    const double age_s = toSeconds(mission_.status().stamp - toStamp(transform.header.stamp));
    const bool is_static = transform.header.stamp.isZero();
    if (frame == params_.map_frame && !is_static && age_s > params_.map_timeout_s)
      return "the transform from \"" + frame + "\" is stale: the last one is " + std::to_string(age_s) +
             " s old";
    geometry_msgs::PoseStamped odom_goal;
    tf2::doTransform(goal, odom_goal, transform);
    if (const std::optional<Pose2> pose = planar(odom_goal.pose)) return *pose;
    return "goal is not finite";
  } catch (const tf2::TransformException& error) {
    return "goal in an unknown frame: \"" + frame + "\": " + error.what();
  }
}

void MissionNode::onOdometry(const nav_msgs::Odometry& msg) {
  const std::optional<Odometry> odometry = fromRos(msg);
  if (!odometry) {
    diagnostics_.input("odom").refused("not finite, or no sound quaternion");
    return;
  }
  if (msg.header.frame_id != params_.odom_frame) {
    diagnostics_.input("odom").refused("frame \"" + msg.header.frame_id + "\" instead of \"" +
                                       params_.odom_frame + "\"");
    ROS_WARN_THROTTLE(5.0, "odometry in frame \"%s\" is not used: goals are in \"%s\"",
                      msg.header.frame_id.c_str(), params_.odom_frame.c_str());
    return;
  }
  diagnostics_.input("odom").received(odometry->stamp, toStamp(checkClock()));
  moveMapGoal();
  const MissionOutput output = mission_.update(*odometry);
  if (output.command) {
    geometry_msgs::TwistStamped command;
    command.header.stamp = msg.header.stamp;
    command.header.frame_id = params_.base_frame;
    command.twist = toRos(*output.command);
    command_pub_.publish(command);
  }
  publishStatus();
  publishFeedback(msg);
  reportEnds();
  if (tour_) driveTour(msg.header.stamp);
}

void MissionNode::moveMapGoal() {
  if (!map_goal_ || !mission_.active()) return;
  const std::variant<Pose2, std::string> place = toOdom(*map_goal_);
  if (const auto* fault = std::get_if<std::string>(&place)) {
    mission_.holdGoal(*fault);
    return;
  }
  mission_.moveGoal(std::get<Pose2>(place));
  if (mission_.goalChanges() != goal_changes_) publishGoal(toRos(mission_.status().stamp));
}

void MissionNode::onPath(const nav_msgs::Path& msg) {
  const std::optional<Path2> path = fromRos(msg);
  if (!path) {
    diagnostics_.input("path").refused("not finite, or no sound quaternion");
    return;
  }
  diagnostics_.input("path").received(toStamp(msg.header.stamp), toStamp(checkClock()));
  mission_.setPath(*path, toStamp(msg.header.stamp), path->empty() ? path_reason_ : "");
  reportEnds();
}

void MissionNode::onLocalCommand(const LocalCommand& msg) {
  const std::optional<MotionCommand> command = fromRos(msg);
  if (!command) {
    diagnostics_.input("avoidance/command").refused("unknown status, or not finite");
    return;
  }
  diagnostics_.input("avoidance/command").received(command->stamp, toStamp(checkClock()));
  mission_.setLocalCommand(*command);
  reportEnds();
}

bool MissionNode::onSetManual(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
  mission_.setManual(request.data != 0);
  publishStatus();
  reportEnds();
  response.success = 1;
  response.message = request.data != 0 ? "manual: the base follows cmd_vel_in" : "automatic";
  return true;
}

// To be called before anything of a new time is taken in.
ros::Time MissionNode::checkClock() {
  const ros::Time now = ros::Time::now();
  if (now < last_now_) {
    ROS_WARN("time jumped back from %.3f to %.3f: starting anew", last_now_.toSec(), now.toSec());
    mission_.resetTime();
    reportEnds();
  }
  last_now_ = now;
  return now;
}

void MissionNode::onTimer() {
  const ros::Time now = checkClock();
  if (mission_.checkOdometry(toStamp(now))) publishStatus();
  reportEnds();
}

// Tells the clients, the log and the tour how goals have ended.
void MissionNode::reportEnds() {
  for (const MissionEvent& event : mission_.takeEvents()) {
    const bool reached = event.phase == MissionPhase::kReached;
    ROS_LOG(reached ? ros::console::levels::Info : ros::console::levels::Warn, ROSCONSOLE_DEFAULT_NAME,
            "goal %u: %s", event.goal_number, event.reason.c_str());
    if (!goal_handle_) continue;
    GoalHandle handle = *goal_handle_;
    goal_handle_.reset();
    const move_base_msgs::MoveBaseResult result;
    if (reached) {
      handle.setSucceeded(result, event.reason);
    } else if (event.phase == MissionPhase::kCancelled) {
      handle.setCanceled(result, event.reason);
    } else {
      handle.setAborted(result, event.reason);
    }
    if (tour_ && handle.getGoalID().id == tour_goal_id_) onTourGoalEnd(event);
  }
}

void MissionNode::publishStatus() {
  MissionState state = toRos(mission_.status());
  const bool moves = mission_.status().mode != Mode::kIdle && mission_.status().mode != Mode::kManual;
  if (moves && state.reason != told_reason_) ROS_INFO("%s", state.reason.c_str());
  told_reason_ = state.reason;
  state.header.frame_id = params_.odom_frame;
  state_pub_.publish(state);
  const bool aborted = mission_.status().phase == MissionPhase::kAborted;
  diagnostics_.status(
      aborted ? diagnostic_msgs::DiagnosticStatus::WARN : diagnostic_msgs::DiagnosticStatus::OK,
      mission_.status().reason.empty() ? "no goal yet" : mission_.status().reason);
  diagnostics_.set("goal number", mission_.status().goal_number);
  diagnostics_.set("recoveries", mission_.recoveries());
}

void MissionNode::publishFeedback(const nav_msgs::Odometry& msg) {
  if (!goal_handle_ || !mission_.active()) return;
  const double since_s = (msg.header.stamp - last_feedback_).toSec();
  if (since_s >= 0.0 && since_s < 1.0 / params_.feedback_rate_hz) return;
  last_feedback_ = msg.header.stamp;
  move_base_msgs::MoveBaseFeedback feedback;
  feedback.base_position.header = msg.header;
  feedback.base_position.pose = msg.pose.pose;
  goal_handle_->publishFeedback(feedback);
}

void MissionNode::driveTour(ros::Time now) {
  if (tour_start_.isZero()) tour_start_ = now + ros::Duration(tour_->start_delay_s);
  const bool connected = action_goal_pub_.getNumSubscribers() > 0;
  if (!tour_goal_id_.empty() || !connected || now < tour_start_) return;
  const std::variant<Pose2, std::string> place = toOdom(tourGoal());
  if (const auto* fault = std::get_if<std::string>(&place)) {
    ROS_WARN_THROTTLE(5.0, "the tour waits: %s", fault->c_str());
    diagnostics_.status(diagnostic_msgs::DiagnosticStatus::WARN, "the tour waits: " + *fault);
  } else {
    sendTourGoal(now);
  }
}

geometry_msgs::PoseStamped MissionNode::tourGoal() const {
  const Waypoint& waypoint = tour_->waypoints[next_waypoint_];
  geometry_msgs::PoseStamped goal;
  goal.header.frame_id = tour_->frame;
  goal.pose = toRos(Pose2{waypoint.position.x(), waypoint.position.y(), waypoint.yaw_rad.value_or(0.0)});
  return goal;
}

// A tour's goals go through the action server like anyone's, so that they are cancelled in the same way.
void MissionNode::sendTourGoal(ros::Time now) {
  tour_goal_id_ = "waypoint " + std::to_string(next_waypoint_ + 1) + " at " + std::to_string(now.toSec());
  move_base_msgs::MoveBaseActionGoal action;
  action.header.stamp = action.goal_id.stamp = ros::Time::now();  // as clients stamp theirs
  action.goal_id.id = tour_goal_id_;
  action.goal.target_pose = tourGoal();
  action.goal.target_pose.header.stamp = now;
  action_goal_pub_.publish(action);
}

void MissionNode::onTourGoalEnd(const MissionEvent& event) {
  tour_goal_id_.clear();
  if (event.phase != MissionPhase::kReached) {
    ROS_WARN("the tour ends at waypoint %zu: %s", next_waypoint_ + 1, event.reason.c_str());
    tour_.reset();
    return;
  }
  if (++next_waypoint_ < tour_->waypoints.size()) return;
  next_waypoint_ = 0;
  if (tour_->loop) return;
  ROS_INFO("the tour is done");
  tour_.reset();
}

}  // namespace frugal_nav
