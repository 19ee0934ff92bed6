#include "depth_drive.hpp"
#include "node_params.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <frugal_nav/eval/camera_stack.hpp>
#include <frugal_nav/eval/stopwatch.hpp>
#include <frugal_nav/robot/param_file.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kPeriods = 2.5;  // of the pipeline, that its results may be old

std::unique_ptr<Detector> orDetector(std::unique_ptr<Detector> given, const CameraStackParams& params) {
  if (given) return given;
  return std::make_unique<YoloDetector>(params.detector, params.models_dir);
}

std::unique_ptr<DepthNetwork> orNetwork(std::unique_ptr<DepthNetwork> given,
                                        const CameraStackParams& params) {
  if (given) return given;
  return std::make_unique<OnnxDepthNetwork>(params.network, params.models_dir);
}

std::optional<KnownGoal> knownGoal(const GoalFrame& frame) {
  if (!frame.goal) return std::nullopt;
  KnownGoal goal;
  goal.p_odom = frame.goal->p_odom;
  goal.covariance_m2 = frame.goal->covariance_m2;
  goal.above_floor_m = frame.goal->above_floor_m;
  goal.seen = frame.state == GoalTracker::State::kSeen;
  if (frame.goal_detection) goal.box_px = frame.detections[*frame.goal_detection].box;
  return goal;
}

}  // namespace

CameraStackParams loadCameraStack(const std::string& share_dir) {
  const std::string config = share_dir + "/config/";
  CameraStackParams params;
  params.models_dir = share_dir + "/models";
  params.detector = loadParamFile<YoloParams>(config + "models/heads.yaml");
  params.network = loadParamFile<DepthNetworkParams>(config + "models/depth_small.yaml");
  params.feet = loadPart<FeetParams>({config + "goal_detector.yaml"}, "feet/");
  params.closer_look = loadPart<CloserLookParams>({config + "goal_detector.yaml"}, "closer_look/");
  params.odometry = loadPart<WheelOdometryParams>(
      {config + "wheel_odometry.yaml", config + "simulated/wheel_odometry.yaml"});
  params.range = loadPart<HeadRangeParams>({config + "goal_detector.yaml"}, "head/");
  params.tracker = loadPart<GoalTrackerParams>({config + "goal_detector.yaml"}, "tracker/");
  params.visual = loadPart<VisualOdometryParams>({config + "visual_odometry.yaml"});
  params.depth = loadPart<DepthGapParams>({config + "depth_gap.yaml"});
  params.planner = loadPart<CameraPlannerParams>({config + "camera_planner.yaml"});
  params.mission = loadPart<MissionParams>({config + "mission.yaml", config + "hybrid/mission.yaml"});
  params.base =
      loadPart<BaseControlParams>({config + "base_controller.yaml", config + "hybrid/base_controller.yaml"});
  return params;
}

void adapt(CameraStackParams& params, double speed_mps, double rate_hz) {
  const double oldest_s = kPeriods / rate_hz;
  BaseTimeouts& timeouts = params.base.timeouts;
  for (double* timeout_s : {&timeouts.path_s, &timeouts.obstacle_s, &timeouts.depth_scan_s})
    *timeout_s = std::max(*timeout_s, oldest_s);
  params.tracker.confirm_within_s = std::max(params.tracker.confirm_within_s, oldest_s);
  params.mission.input_timeout_s = std::max(params.mission.input_timeout_s, oldest_s);
  params.base.path.cruise_mps = speed_mps;
  params.planner.right_of_way.cruise_mps = speed_mps;
  params.base.limits.max_v_mps = speed_mps;
  params.base.limits.creep_mps = std::min(params.base.limits.creep_mps, speed_mps);
}

CameraStack::CameraStack(const CameraStackParams& params, const RobotModel& robot, const Pinhole& camera,
                         Duration latency, std::unique_ptr<Detector> detector,
                         std::unique_ptr<DepthNetwork> network)
    : camera_(camera),
      base_from_optical_(robot.baseFrom("camera_optical_frame")),
      latency_(latency),
      wheels_(params.odometry, {robot.drive.radius_m, robot.drive.separation_m}),
      finder_(orDetector(std::move(detector), params), params.range, params.tracker, params.feet,
              params.closer_look),
      visual_(params.visual, camera, base_from_optical_),
      depth_(orNetwork(std::move(network), params), params.depth),
      planner_(params.planner, {robot.halfWidth_m(), robot.circumradius_m()}),
      mission_(params.mission),
      base_(params.base, {robot.footprint, robot.drive.separation_m}) {}

void CameraStack::addImage(Stamp stamp, const cv::Mat& bgr) { pictures_.push_back({stamp, bgr}); }

void CameraStack::cycle(Stamp stamp) {
  command_ = base_.cycle(stamp);
  mission_.setBaseCommand(command_.velocity, stamp);
}

BaseCommand CameraStack::addTicks(Stamp stamp, std::int64_t left, std::int64_t right) {
  if (const auto odometry = wheels_.addTicks(stamp, left, right)) {
    odometry_ = *odometry;
    buffer_.add(odometry_);
    base_.setOdometry(odometry_);
    const MissionOutput output = mission_.update(odometry_);
    base_.setMission(output.status);
    if (output.command) base_.setMissionCommand(*output.command, output.status.stamp);
  }
  cycle(stamp);
  while (!pictures_.empty() && buffer_.covers(pictures_.front().stamp)) {
    pending_.push_back(look(pictures_.front()));
    pictures_.pop_front();
  }
  while (!pending_.empty() && pending_.front().stamp + latency_ <= stamp) {
    takeEffect(std::move(pending_.front()));
    pending_.pop_front();
    cycle(stamp);
  }
  return command_;
}

CameraResult CameraStack::look(const Picture& picture) {
  CameraResult result;
  result.stamp = picture.stamp;
  result.bgr = picture.bgr;
  result.odom_from_base = buffer_.at(picture.stamp)->odom_from_base;
  const std::uint64_t runs_before = finder_.detector().counts().images;
  const double begin_ms = wallTime_ms();
  result.goal =
      finder_.look({picture.stamp, picture.bgr, camera_, base_from_optical_, result.odom_from_base});
  const double found_ms = wallTime_ms();
  VisualInput input;
  input.stamp = picture.stamp;
  input.image = picture.bgr;
  input.odom_from_base = toIsometry(result.odom_from_base);
  if (nearest_) input.region = regionOf(*nearest_);
  result.visual = visual_.process(input);
  const double visual_ms = wallTime_ms();
  DepthView view;
  view.stamp = picture.stamp;
  view.bgr = picture.bgr;
  view.camera = camera_;
  view.base_from_optical = base_from_optical_;
  view.odom_from_base = result.odom_from_base;
  view.points = metricPoints(result.visual, base_from_optical_, result.odom_from_base);
  view.goal = knownGoal(result.goal);
  result.depth = depth_.look(view);
  nearest_ = result.depth.obstacle;
  finder_.addSurfaces(result.depth.scan);
  times_.detector_ms = found_ms - begin_ms;
  times_.detector_runs = static_cast<int>(finder_.detector().counts().images - runs_before);
  times_.visual_ms = visual_ms - found_ms;
  times_.depth_ms = wallTime_ms() - visual_ms;
  return result;
}

void CameraStack::passGoal() {
  const std::optional<Pose2> goal = mission_.active() ? std::optional<Pose2>(mission_.goal()) : std::nullopt;
  planner_.setGoal(goal, mission_.person());
}

void CameraStack::takeEffect(CameraResult result) {
  const double begin_ms = wallTime_ms();
  if (result.goal.observed) mission_.setObservedGoal(result.goal.goal->p_odom, result.stamp);
  passGoal();
  CameraObservation observation;
  observation.stamp = result.stamp;
  observation.gap = result.depth.gap;
  observation.obstacle = result.depth.obstacle;
  observation.scan = result.depth.scan;
  observation.odometry = *buffer_.at(result.stamp);
  observation.fault = result.depth.fault;
  result.plan = planner_.update(observation);
  mission_.setPath(result.plan.path, result.plan.stamp, result.plan.reason);
  base_.setObstacle(result.depth.obstacle);
  base_.setDepthScan(result.depth.scan);
  base_.setPath(result.plan.path, result.plan.stamp);
  times_.plan_ms = wallTime_ms() - begin_ms;
  last_ = std::move(result);
}

}  // namespace frugal_nav::eval
