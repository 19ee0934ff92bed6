#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include <actionlib/client/simple_action_client.h>
#include <geometry_msgs/PoseStamped.h>
#include <move_base_msgs/MoveBaseAction.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <topic_tools/shape_shifter.h>

#include <frugal_nav/LocalCommand.h>
#include <frugal_nav/MissionState.h>
#include <frugal_nav/ros/conversions.hpp>

// Sends the robot to a goal as any client of move_base does, watches the drive, and ends with one line
// RESULT.
namespace frugal_nav {
namespace {

constexpr double kGoalRadius_m = 0.30;
constexpr double kStartTimeout_s = 60.0;  // wall time for the graph to come up
constexpr double kStillTimeout_s = 30.0;  // wall time without any progress of ROS time
constexpr const char* kWorld = "world";
constexpr const char* kLocalCommand = "avoidance/command";
// So many commands of a local planner without a goal, a second's worth, show that the graph is up and
// connected.
constexpr int kSettledCommands = 10;

constexpr const char* kUsage =
    "usage: drive_to X Y [YAW] [--frame FRAME] [--timeout S] [--observed]\n"
    "  X Y      goal in metres; YAW in radians, without it the heading is that of the straight line\n"
    "  --frame  frame of the goal: odom (default), world (the simulator's), or any frame of tf\n"
    "  --timeout  simulated seconds after which the goal is cancelled (default 300)\n"
    "  --observed  sends no goal: the mission finds one itself, by the camera, and X Y is where it should "
    "end\n";

struct Options {
  Pose2 goal;
  bool has_yaw = false;
  std::string frame = "odom";
  double timeout_s = 300.0;
  bool observed = false;
};

std::optional<double> number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0') return std::nullopt;
  return value;
}

std::optional<Options> parse(const std::vector<std::string>& arguments) {
  Options options;
  std::vector<double> numbers;
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    const bool has_value = i + 1 < arguments.size();
    if (arguments[i] == "--observed") {
      options.observed = true;
    } else if (arguments[i] == "--frame" && has_value) {
      options.frame = arguments[++i];
    } else if (arguments[i] == "--timeout" && has_value) {
      const std::optional<double> value = number(arguments[++i]);
      if (!value) return std::nullopt;
      options.timeout_s = *value;
    } else if (const std::optional<double> value = number(arguments[i])) {
      numbers.push_back(*value);
    } else {
      return std::nullopt;
    }
  }
  if (numbers.size() != 2 && numbers.size() != 3) return std::nullopt;
  options.has_yaw = numbers.size() == 3;
  options.goal = {numbers[0], numbers[1], options.has_yaw ? numbers[2] : 0.0};
  return options;
}

bool isPublished(const std::string& topic) {
  ros::master::V_TopicInfo topics;
  ros::master::getTopics(topics);
  for (const ros::master::TopicInfo& info : topics) {
    if (info.name == topic) return true;
  }
  return false;
}

class DriveTo {
 public:
  explicit DriveTo(const Options& options) : options_(options), client_("move_base", false) {
    odometry_sub_ = nh_.subscribe("odom", 5, &DriveTo::onOdometry, this);
    truth_sub_ = nh_.subscribe("ground_truth/odom", 5, &DriveTo::onTruth, this);
    contact_sub_ = nh_.subscribe("ground_truth/contact", 100, &DriveTo::onContact, this);
    local_sub_ = nh_.subscribe(kLocalCommand, 5, &DriveTo::onLocalCommand, this);
    goal_sub_ = nh_.subscribe("mission/goal", 1, &DriveTo::onMissionGoal, this);
    state_sub_ = nh_.subscribe("mission/state", 50, &DriveTo::onState, this);
  }

  /// The whole drive; true when the robot stands at the goal without having touched anything.
  bool run() {
    const bool reached = waitForGraph() && sendGoal() && watch();
    return report(reached);
  }

 private:
  bool waitForGraph() {
    const ros::WallTime start = ros::WallTime::now();
    while (ros::ok()) {
      spin();
      if (client_.isServerConnected() && odometry_) {
        with_truth_ = isPublished(nh_.resolveName("ground_truth/odom"));
        const bool plans = options_.observed || local_commands_ >= kSettledCommands ||
                           !isPublished(nh_.resolveName(kLocalCommand));
        if (plans && (!with_truth_ || truth_)) return true;
      }
      if ((ros::WallTime::now() - start).toSec() > kStartTimeout_s) {
        std::printf("drive_to: not ready after %.0f s: %s\n", kStartTimeout_s, missing().c_str());
        return false;
      }
    }
    return false;
  }

  std::string missing() const {
    if (!client_.isServerConnected()) return "no action server move_base; is the mission node running?";
    if (!odometry_) return "no message on odom; is the robot running?";
    if (with_truth_ && !truth_) return "no message on ground_truth/odom";
    return local_reason_.empty() ? std::string("no message on ") + kLocalCommand : local_reason_;
  }

  bool sendGoal() {
    // The robot stands: the two poses belong together even though their stamps may differ.
    if (with_truth_) world_from_odom_ = *truth_ * odometry_->inverse();
    Pose2 goal = options_.goal;
    std::string frame = options_.frame;
    if (frame == kWorld) {
      if (!world_from_odom_) {
        std::printf("drive_to: a goal in the frame world needs the simulator's ground_truth/odom\n");
        return false;
      }
      goal = world_from_odom_->inverse() * goal;
      frame = "odom";
    }
    if (options_.observed && frame != "odom") {
      std::printf("drive_to: --observed needs the place in the frame odom or world\n");
      return false;
    }
    if (!options_.has_yaw && frame == "odom")
      goal.yaw_rad = std::atan2(goal.y_m - odometry_->y_m, goal.x_m - odometry_->x_m);
    move_base_msgs::MoveBaseGoal msg;
    msg.target_pose.header.frame_id = frame;
    msg.target_pose.header.stamp = ros::Time::now();
    msg.target_pose.pose = toRos(goal);
    goal_ = frame == "odom" ? std::optional<Pose2>(goal) : std::nullopt;
    start_ = ros::Time::now();
    driven_m_ = 0.0;
    sent_ = true;
    if (options_.observed) {
      std::printf("drive_to: waiting for the mission to see a goal and to drive there\n");
      return true;
    }
    contacts_ = 0;
    client_.sendGoal(msg);
    std::printf("drive_to: goal (%.2f, %.2f) in %s, %.2f m away\n", goal.x_m, goal.y_m, frame.c_str(),
                distance(*odometry_, goal));
    return true;
  }

  /// Waits for the end; true when the goal was reached.
  bool watch() {
    ros::Time last_time = start_;
    ros::WallTime last_change = ros::WallTime::now();
    double next_line_s = 10.0;
    while (ros::ok() && !isDone()) {
      spin();
      const ros::Time now = ros::Time::now();
      if (now != last_time) last_change = ros::WallTime::now();
      last_time = now;
      if ((ros::WallTime::now() - last_change).toSec() > kStillTimeout_s) {
        std::printf("drive_to: time stands still; has the simulator died?\n");
        return false;
      }
      const double elapsed_s = (now - start_).toSec();
      if (elapsed_s >= next_line_s) {
        next_line_s += 10.0;
        std::printf("drive_to: %.0f s, %.1f m driven%s\n", elapsed_s, driven_m_, remaining().c_str());
        std::fflush(stdout);
      }
      if (elapsed_s >= options_.timeout_s) {
        std::printf("drive_to: not there after %.0f s: cancelling\n", elapsed_s);
        client_.cancelAllGoals();
        spinFor(1.0);
        return false;
      }
    }
    end_ = ros::Time::now();
    spinFor(0.5);  // the robot stands; contacts of the last moment still come in
    if (!ros::ok()) return false;
    if (options_.observed) {
      std::printf("drive_to: %s: %s\n", state_ == MissionState::STATE_REACHED ? "REACHED" : "ENDED",
                  state_reason_.c_str());
      return state_ == MissionState::STATE_REACHED;
    }
    const actionlib::SimpleClientGoalState state = client_.getState();
    std::printf("drive_to: %s: %s\n", state.toString().c_str(), state.getText().c_str());
    return state == actionlib::SimpleClientGoalState::SUCCEEDED;
  }

  bool isDone() const {
    if (!options_.observed) return client_.getState().isDone();
    return state_ == MissionState::STATE_REACHED || state_ == MissionState::STATE_ABORTED ||
           state_ == MissionState::STATE_CANCELLED;
  }

  bool report(bool reached) {
    const std::optional<double> error_m = goalError();
    const bool success = reached && contacts_ == 0 && error_m && *error_m <= kGoalRadius_m;
    const ros::Time end = end_.isZero() ? ros::Time::now() : end_;
    const double time_s = sent_ ? (end - start_).toSec() : 0.0;
    std::printf("drive_to: %.2f m driven in %.1f s, goal error from %s\n", driven_m_, time_s,
                world_from_odom_ ? "ground truth" : "odometry");
    const std::string contacts = with_truth_ ? std::to_string(contacts_) : "null";
    char error[32] = "null";
    if (error_m) std::snprintf(error, sizeof error, "%.2f", *error_m);
    std::printf("RESULT success=%d contacts=%s goal_error_m=%s time_s=%.1f\n", success ? 1 : 0,
                contacts.c_str(), error, time_s);
    std::fflush(stdout);
    return success;
  }

  std::optional<double> goalError() const {
    if (!goal_ || !odometry_) return std::nullopt;
    if (world_from_odom_) return distance(*truth_, *world_from_odom_ * *goal_);
    return distance(*odometry_, *goal_);
  }

  std::string remaining() const {
    const std::optional<double> error_m = goalError();
    if (!error_m) return "";
    char text[64];
    std::snprintf(text, sizeof text, ", %.1f m to the goal", *error_m);
    return text;
  }

  void spin() {
    ros::spinOnce();
    ros::WallDuration(0.01).sleep();
  }

  void spinFor(double ros_seconds) {
    const ros::Time end = ros::Time::now() + ros::Duration(ros_seconds);
    const ros::WallTime wall_end = ros::WallTime::now() + ros::WallDuration(10.0);
    while (ros::ok() && ros::Time::now() < end && ros::WallTime::now() < wall_end) spin();
  }

  void onOdometry(const nav_msgs::Odometry& msg) {
    const std::optional<Pose2> pose = planar(msg.pose.pose);
    if (!pose) return;
    if (odometry_ && !with_truth_) driven_m_ += distance(*odometry_, *pose);
    odometry_ = pose;
  }

  void onTruth(const nav_msgs::Odometry& msg) {
    const std::optional<Pose2> pose = planar(msg.pose.pose);
    if (!pose) return;
    if (truth_ && with_truth_) driven_m_ += distance(*truth_, *pose);
    truth_ = pose;
  }

  void onLocalCommand(const LocalCommand& msg) {
    const bool works = msg.status != LocalCommand::STATUS_STOPPED;
    local_commands_ = works ? local_commands_ + 1 : 0;
    local_reason_ = works ? "" : msg.reason;
  }

  void onContact(const topic_tools::ShapeShifter&) { ++contacts_; }

  void onState(const MissionState& msg) {
    state_ = msg.state;
    state_reason_ = msg.reason;
  }

  // The goal as the mission understood it: what the error is measured against when it came in another frame.
  void onMissionGoal(const geometry_msgs::PoseStamped& msg) {
    if (sent_ && !goal_) goal_ = planar(msg.pose);
  }

  Options options_;
  ros::NodeHandle nh_;
  actionlib::SimpleActionClient<move_base_msgs::MoveBaseAction> client_;
  ros::Subscriber odometry_sub_;
  ros::Subscriber truth_sub_;
  ros::Subscriber contact_sub_;
  ros::Subscriber goal_sub_;
  ros::Subscriber local_sub_;
  ros::Subscriber state_sub_;
  std::optional<Pose2> odometry_;  ///< odom_from_base
  std::optional<Pose2> truth_;     ///< world_from_base
  std::optional<Pose2> world_from_odom_;
  std::optional<Pose2> goal_;  ///< odom_from_goal
  bool with_truth_ = false;
  bool sent_ = false;
  int local_commands_ = 0;  ///< in a row, since the local planner was last stopped
  std::string local_reason_;
  int state_ = MissionState::STATE_IDLE;
  std::string state_reason_;
  ros::Time start_;
  ros::Time end_;
  double driven_m_ = 0.0;
  int contacts_ = 0;
};

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  std::vector<std::string> arguments;
  ros::removeROSArgs(argc, argv, arguments);
  const std::optional<frugal_nav::Options> options = frugal_nav::parse(arguments);
  if (!options) {
    std::fputs(frugal_nav::kUsage, stderr);
    return 2;
  }
  ros::init(argc, argv, "drive_to", ros::init_options::AnonymousName);
  const ros::NodeHandle nh;
  if (!ros::Time::waitForValid(ros::WallDuration(frugal_nav::kStartTimeout_s))) {
    std::printf(
        "drive_to: no /clock; is the simulator running?\nRESULT success=0 contacts=null goal_error_m=null "
        "time_s=0.0\n");
    return 1;
  }
  return frugal_nav::DriveTo(*options).run() ? 0 : 1;
}
