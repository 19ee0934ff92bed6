#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/ros.h>
#include <sensor_msgs/Imu.h>
#include <std_srvs/SetBool.h>
#include <tf2_ros/transform_broadcaster.h>

#include <frugal_nav/SetPose.h>
#include <frugal_nav/localization/marker_localization.hpp>
#include <frugal_nav/ros/diagnostics.hpp>
#include <frugal_nav/ros/image_intake.hpp>
#include <frugal_nav/ros/live_parameters.hpp>
#include <frugal_nav/ros/marker_localization_node_params.hpp>
#include <frugal_nav/ros/sensor_poses.hpp>

namespace frugal_nav {

/// Camera, odom (or cmd_vel_stamped) and imu/data_raw in; markers for every image, pose and the tf from map
/// to odom for every odom from the first fix on. Everything it decides is MarkerLocalization's.
///
/// The tf has the stamp of the odom it came with, and each stamp once. While odom is silent the pose goes on
/// with the images, and the tf stands.
class MarkerLocalizationNode {
 public:
  /// Throws ConfigError on bad parameters, and when the marker map is missing or wrong.
  MarkerLocalizationNode(ros::NodeHandle nh, ros::NodeHandle pnh);
  MarkerLocalizationNode(const MarkerLocalizationNode&) = delete;  // callbacks hold its address
  MarkerLocalizationNode& operator=(const MarkerLocalizationNode&) = delete;

 private:
  using PoseMessage = geometry_msgs::PoseWithCovarianceStamped;

  void subscribe();
  void advertiseServices();
  void onOdometry(const nav_msgs::Odometry& msg);
  void onCommand(const geometry_msgs::TwistStamped& msg);
  void onImu(const sensor_msgs::Imu& msg);
  void process(const CameraFrame& frame);
  /// Why the pose was refused; empty when the robot is there now.
  std::string setPose(const std::string& input, const PoseMessage& msg);
  void addSwitch(const std::string& name, FilterInput input, bool at_first);

  bool isStamped(const std::string& input, const std_msgs::Header& header);
  void note(const std::string& input, Stamp stamp, FilterStatus status);
  void publishPose(const PoseEstimate& estimate);
  void publishWithoutOdometry(Stamp stamp);
  void broadcast(Stamp stamp, const Pose2& map_from_odom);
  void show(const CameraFrame& frame, const MarkerImageResult& result);
  void showPath(const PoseEstimate& estimate);
  void report(const MarkerImageResult& result);
  void reportStatus();
  void forget();

  ros::NodeHandle nh_;
  ros::NodeHandle pnh_;
  MarkerLocalizationNodeParams params_;
  MarkerLocalization localization_;
  NodeDiagnostics diagnostics_;
  SensorPoses sensors_;
  LocalizationStatus::State told_ = LocalizationStatus::State::kNoFix;
  std::uint64_t told_restarts_ = 0;
  std::string silence_;  ///< why no image comes; empty while they do
  nav_msgs::Path path_;

  std::unique_ptr<ImageIntake> intake_;
  ros::Publisher observations_pub_;
  ros::Publisher fix_pub_;
  ros::Publisher pose_pub_;
  ros::Publisher markers_pub_;
  ros::Publisher path_pub_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::vector<ros::Subscriber> subscribers_;
  std::vector<ros::ServiceServer> services_;
  ros::Timer timer_;
  std::unique_ptr<LiveParameterServer> live_;
};

}  // namespace frugal_nav
