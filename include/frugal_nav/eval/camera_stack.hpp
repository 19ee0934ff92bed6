#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include <frugal_nav/common/odometry_buffer.hpp>
#include <frugal_nav/common/pinhole.hpp>
#include <frugal_nav/control/base_control.hpp>
#include <frugal_nav/mission/mission.hpp>
#include <frugal_nav/odometry/visual_odometry.hpp>
#include <frugal_nav/odometry/visual_params.hpp>
#include <frugal_nav/odometry/wheel_odometry.hpp>
#include <frugal_nav/perception/depth_gap.hpp>
#include <frugal_nav/perception/depth_network.hpp>
#include <frugal_nav/perception/goal_finder.hpp>
#include <frugal_nav/perception/yolo_detector.hpp>
#include <frugal_nav/planning/camera_planner.hpp>
#include <frugal_nav/robot/robot_model.hpp>

namespace frugal_nav::eval {

/// The parameters of every node between the camera and cmd_vel.
struct CameraStackParams {
  std::string models_dir;
  YoloParams detector;
  HeadRangeParams range;
  GoalTrackerParams tracker;
  FeetParams feet;
  CloserLookParams closer_look;
  DepthNetworkParams network;
  WheelOdometryParams odometry;
  VisualOdometryParams visual;
  DepthGapParams depth;
  CameraPlannerParams planner;
  MissionParams mission;
  BaseControlParams base;
};

/// The parameter files that hybrid.launch gives the nodes, read from the package's folder; what only the node
/// class uses is left out. Throws ConfigError as loadParamFile().
CameraStackParams loadCameraStack(const std::string& share_dir);

/// Cruises at a speed, and fits the time-outs to a pipeline that gives `rate_hz` results a second: 2.5 of its
/// periods, and no less than the parameters say.
void adapt(CameraStackParams& params, double speed_mps, double rate_hz);

/// What one image led to.
struct CameraResult {
  Stamp stamp{};
  cv::Mat bgr;
  Pose2 odom_from_base;  ///< at the stamp
  GoalFrame goal;
  VisualOdometryOutput visual;
  DepthFrame depth;
  CameraPlan plan;  ///< empty until the result has taken effect
};

/// Processor time of the stages of the last image, networks apart [ms].
struct CameraStageTimes {
  double detector_ms = 0.0;  ///< the detector as a whole
  int detector_runs = 0;     ///< of its network: more than one where it looked again, closer
  double visual_ms = 0.0;
  double depth_ms = 0.0;  ///< with its network
  double plan_ms = 0.0;   ///< planner, mission and base
};

/// The node graph of hybrid.launch in one process: the same classes, called in the order in which the graph's
/// messages arrive.
class CameraStack {
 public:
  /// What an image shows takes effect `latency` after its stamp. The networks may be given, for tests;
  /// otherwise they are read from params.models_dir. Throws ConfigError as the nodes do.
  CameraStack(const CameraStackParams& params, const RobotModel& robot, const Pinhole& camera,
              Duration latency, std::unique_ptr<Detector> detector = nullptr,
              std::unique_ptr<DepthNetwork> network = nullptr);

  /// ticks -> odometry -> mission -> base; before it the images that are due -> planner -> base.
  BaseCommand addTicks(Stamp stamp, std::int64_t left, std::int64_t right);
  /// An image (CV_8UC3, BGR); it is looked at once odometry of its stamp is in.
  void addImage(Stamp stamp, const cv::Mat& bgr);

  /// The newest odometry; at the origin of odom before the first ticks.
  const Odometry& odometry() const { return odometry_; }
  const Mission& mission() const { return mission_; }
  const CameraPlanner& planner() const { return planner_; }
  /// The newest image's result that has taken effect; nothing before the first.
  const std::optional<CameraResult>& last() const { return last_; }
  const BaseCommand& command() const { return command_; }
  const CameraStageTimes& times() const { return times_; }

 private:
  struct Picture {
    Stamp stamp{};
    cv::Mat bgr;
  };
  CameraResult look(const Picture& picture);
  void takeEffect(CameraResult result);
  void cycle(Stamp stamp);
  void passGoal();

  Pinhole camera_;
  Eigen::Isometry3d base_from_optical_;
  Duration latency_;
  WheelOdometry wheels_;
  GoalFinder finder_;
  VisualOdometry visual_;
  DepthGap depth_;
  CameraPlanner planner_;
  Mission mission_;
  BaseControl base_;
  OdometryBuffer buffer_;
  Odometry odometry_;
  std::deque<Picture> pictures_;
  std::deque<CameraResult> pending_;
  std::optional<NearestObstacle> nearest_;
  std::optional<CameraResult> last_;
  BaseCommand command_;
  CameraStageTimes times_;
};

}  // namespace frugal_nav::eval
