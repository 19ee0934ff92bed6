#include <frugal_nav/ros/conversions.hpp>
#include <frugal_nav/ros/goal_intake.hpp>

namespace frugal_nav {
namespace {

bool isUnderway(MissionPhase phase) {
  return phase == MissionPhase::kDriving || phase == MissionPhase::kRecovering;
}

}  // namespace

GoalIntake::GoalIntake(ros::NodeHandle nh, std::string odom_frame, Mode drive_mode,
                       NodeDiagnostics& diagnostics, TimeJumpWatch& time)
    : odom_frame_(std::move(odom_frame)), drive_mode_(drive_mode), diagnostics_(diagnostics), time_(time) {
  for (const char* topic : {"mission/goal", "mission/state"}) diagnostics_.input(topic);
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  goal_sub_ = nh.subscribe("mission/goal", 1, &GoalIntake::onGoal, this, hints);
  state_sub_ = nh.subscribe("mission/state", 10, &GoalIntake::onState, this, hints);
}

std::optional<Pose2> GoalIntake::goal() const {
  const bool wanted =
      mission_.mode == drive_mode_ || mission_.mode == Mode::kAligning || mission_.mode == Mode::kRecovering;
  // A goal older than its number is the one before.
  const bool is_present = isUnderway(mission_.phase) && wanted && goal_stamp_ >= number_before_;
  return is_present ? goal_ : std::nullopt;
}

void GoalIntake::onGoal(const geometry_msgs::PoseStamped& msg) {
  const std::optional<Pose2> goal = planar(msg.pose);
  if (!goal || msg.header.frame_id != odom_frame_) {
    diagnostics_.input("mission/goal")
        .refused(goal ? "not in the frame " + odom_frame_ : "not finite, or no sound quaternion");
    return;
  }
  diagnostics_.input("mission/goal").received(toStamp(msg.header.stamp), toStamp(ros::Time::now()));
  time_.checkClock();
  goal_ = *goal;
  goal_stamp_ = toStamp(msg.header.stamp);
}

void GoalIntake::onState(const MissionState& msg) {
  const std::optional<MissionStatus> status = fromRos(msg);
  if (!status) {
    diagnostics_.input("mission/state").refused("unknown mode or state");
    return;
  }
  diagnostics_.input("mission/state").received(status->stamp, toStamp(ros::Time::now()));
  time_.checkClock();
  if (status->goal_number != mission_.goal_number) number_before_ = mission_.stamp;
  mission_ = *status;
  // An end that is older than the goal is another's.
  if (!isUnderway(mission_.phase) && goal_stamp_ < mission_.stamp) goal_.reset();
}

void GoalIntake::forget(Stamp now) {
  number_before_ = Stamp{};
  mission_ = MissionStatus{};
  if (goal_stamp_ > now) goal_.reset();  // not one of the new time that has come already
}

}  // namespace frugal_nav
