#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>

#include <actionlib/server/action_server.h>
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <move_base_msgs/MoveBaseAction.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/ros.h>
#include <std_msgs/String.h>
#include <std_srvs/SetBool.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <frugal_nav/LocalCommand.h>
#include <frugal_nav/mission/mission.hpp>
#include <frugal_nav/mission/waypoint_list.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/live_parameters.hpp>

namespace frugal_nav {

struct MissionNodeParams {
  std::string odom_frame = "odom";
  std::string base_frame = "base_link";
  std::string map_frame = "map";
  double map_timeout_s = 1.0;
  std::string waypoints_file;
  double feedback_rate_hz = 5.0;
  MissionParams mission;

  template <class Visitor>
  void fields(Visitor&& visit) {
    visit("odom_frame", odom_frame, atStart(Field{"", "frame of goals, path and odometry"}));
    visit("base_frame", base_frame, atStart(Field{"", "frame of mission/command"}));
    visit("map_frame", map_frame,
          atStart(Field{"",
                        "a goal in this frame is put into odom_frame anew with each odometry: the robot "
                        "learns on its way where it is"}));
    visit("map_timeout_s", map_timeout_s,
          Field{"s", "a transform from map_frame older than this against odometry is stale: the robot stands",
                0.05, 60.0});
    visit("waypoints_file", waypoints_file,
          atStart(Field{"", "tour to drive from the start; empty for none"}));
    visit("feedback_rate_hz", feedback_rate_hz,
          Field{"Hz", "base_position to clients of move_base", 0.1, 50.0});
    mission.fields(visit);
  }
  std::string check() const { return mission.check(); }
};

/// Serves `move_base` (MoveBaseAction), `move_base_simple/goal`, a tour from a file and the person on
/// goal/observed; gives mission/goal, mission/state and mission/command. Everything it decides is Mission's.
class MissionNode {
 public:
  /// Throws ConfigError on bad parameters or a bad waypoint file.
  MissionNode(ros::NodeHandle nh, ros::NodeHandle pnh);
  MissionNode(const MissionNode&) = delete;  // callbacks hold its address
  MissionNode& operator=(const MissionNode&) = delete;

 private:
  using GoalId = move_base_msgs::MoveBaseActionGoal::_goal_id_type;
  using GoalHandle = actionlib::ActionServer<move_base_msgs::MoveBaseAction>::GoalHandle;

  void onGoal(GoalHandle handle);
  void onCancel(GoalHandle handle);
  void onCancelAll(const GoalId& id);
  void onSimpleGoal(const geometry_msgs::PoseStamped& goal);
  void onObserved(const geometry_msgs::PoseWithCovarianceStamped& msg);
  void onBaseCommand(const geometry_msgs::TwistStamped& msg);
  void onOdometry(const nav_msgs::Odometry& msg);
  void onPath(const nav_msgs::Path& msg);
  void onLocalCommand(const LocalCommand& msg);
  bool onSetManual(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  void onTimer();
  ros::Time checkClock();

  /// The goal in the odom frame, or why it cannot be driven to.
  std::variant<Pose2, std::string> toOdom(const geometry_msgs::PoseStamped& goal) const;
  /// The present goal of the map to where it is in odom now; or holds it, when nobody can tell.
  void moveMapGoal();
  geometry_msgs::PoseStamped tourGoal() const;
  void reportEnds();
  void publishGoal(ros::Time now);
  void publishStatus();
  void publishFeedback(const nav_msgs::Odometry& msg);
  void driveTour(ros::Time now);
  void sendTourGoal(ros::Time now);
  void onTourGoalEnd(const MissionEvent& event);

  MissionNodeParams params_;
  Mission mission_;
  NodeDiagnostics diagnostics_;
  std::unique_ptr<LiveParameterServer> tuning_;
  tf2_ros::Buffer tf_buffer_;
  tf2_ros::TransformListener tf_listener_;
  actionlib::ActionServer<move_base_msgs::MoveBaseAction> server_;
  std::optional<GoalHandle> goal_handle_;               ///< of the goal on its way
  std::optional<geometry_msgs::PoseStamped> map_goal_;  ///< the present one, when it is in map_frame
  std::string path_reason_;                             ///< of the planner, for an empty path
  std::string told_reason_;                             ///< of the state, when it was last published
  ros::Time last_feedback_;
  ros::Time last_now_;
  std::uint32_t goal_changes_ = 0;  ///< of the mission when its goal was last published

  std::optional<WaypointList> tour_;
  std::size_t next_waypoint_ = 0;
  ros::Time tour_start_;
  std::string tour_goal_id_;  ///< of the tour's goal on its way; empty between two

  ros::Publisher goal_pub_;
  ros::Publisher state_pub_;
  ros::Publisher command_pub_;
  ros::Publisher action_goal_pub_;
  ros::Subscriber odometry_sub_;
  ros::Subscriber path_sub_;
  ros::Subscriber path_reason_sub_;
  ros::Subscriber command_sub_;
  ros::Subscriber simple_goal_sub_;
  ros::Subscriber cancel_sub_;
  ros::Subscriber observed_sub_;
  ros::Subscriber base_command_sub_;
  ros::ServiceServer manual_service_;
  ros::Timer timer_;
};

}  // namespace frugal_nav
