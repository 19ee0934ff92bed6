#include <algorithm>
#include <cmath>
#include <ctime>
#include <deque>
#include <stdexcept>

#include <frugal_nav/common/odometry_buffer.hpp>
#include <frugal_nav/eval/visual_drive.hpp>
#include <frugal_nav/odometry/visual_cloud.hpp>
#include <frugal_nav/odometry/wheel_odometry.hpp>

namespace frugal_nav::eval {
namespace {

/// Drives legs one after the other by the odometry's word.
class LegDriver {
 public:
  LegDriver(std::vector<DriveLeg> legs, const DriveSpeed& speed, const Pose2& start)
      : legs_(std::move(legs)), speed_(speed), leg_start_(start) {}

  bool done() const { return leg_ == legs_.size(); }

  Twist2 command(const Pose2& odom_from_base) {
    if (done()) return {};
    const DriveLeg& leg = legs_[leg_];
    const Pose2 done_so_far = leg_start_.inverse() * odom_from_base;
    if (!is_turning_) {
      const double left_m = leg.length_m - done_so_far.x_m;
      if (left_m > kNear_m) {
        const double v = std::clamp(1.5 * left_m, 0.02, speed_.v_mps);
        return {v, std::clamp(-2.0 * done_so_far.yaw_rad - 2.0 * done_so_far.y_m, -0.5, 0.5)};
      }
      is_turning_ = true;
    }
    const double left_rad =
        angleBetween(odom_from_base.yaw_rad, wrapAngle(leg_start_.yaw_rad + leg.turn_rad));
    if (leg.turn_rad != 0.0 && std::abs(left_rad) > kNear_rad)
      return {0.0, std::copysign(std::clamp(2.0 * std::abs(left_rad), 0.05, speed_.w_radps), left_rad)};
    is_turning_ = false;
    leg_start_ = odom_from_base;
    ++leg_;
    return {};
  }

 private:
  static constexpr double kNear_m = 0.005;
  static constexpr double kNear_rad = 0.005;
  std::vector<DriveLeg> legs_;
  DriveSpeed speed_;
  Pose2 leg_start_;
  std::size_t leg_ = 0;
  bool is_turning_ = false;
};

double processorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

Pinhole pinholeOf(const sim::Camera& camera) {
  const cv::Matx33d k = camera.cameraMatrix();
  const cv::Vec<double, 5> d = camera.distortion();
  return {camera.params().width_px,
          camera.params().height_px,
          k(0, 0),
          k(1, 1),
          k(0, 2),
          k(1, 2),
          d[0],
          d[1],
          d[2],
          d[3],
          d[4]};
}

DriveRecording recordDrive(const sim::Scene& scene, const RobotModel& robot, sim::SimulatorParams params,
                           std::uint64_t seed, const Pose2& world_from_start,
                           const std::vector<DriveLeg>& legs, const DriveSpeed& speed,
                           WheelOdometryParams wheel_params) {
  params.sensors = {true, false, false, true, false};
  sim::Simulator simulator(scene, robot, params, seed, world_from_start);
  wheel_params.ticks_per_revolution = params.encoders.ticks_per_revolution;
  wheel_params.start_x_m = world_from_start.x_m;
  wheel_params.start_y_m = world_from_start.y_m;
  wheel_params.start_yaw_rad = world_from_start.yaw_rad;
  WheelOdometry wheels(wheel_params, {robot.drive.radius_m, robot.drive.separation_m});
  OdometryBuffer buffer;
  OdometryBuffer truths;
  LegDriver driver(legs, speed, world_from_start);

  DriveRecording recording;
  recording.camera = pinholeOf(simulator.camera());
  recording.base_from_camera = robot.baseFrom("camera_optical_frame");
  double limit_s = 20.0;
  for (const DriveLeg& leg : legs)
    limit_s += 3.0 * (leg.length_m / speed.v_mps + std::abs(leg.turn_rad) / speed.w_radps);
  std::deque<sim::CameraImage> waiting;
  Pose2 last = world_from_start;
  while (!driver.done() || !waiting.empty()) {
    const sim::SimOutput output = simulator.step();
    const sim::GroundTruth truth = simulator.groundTruth();
    recording.length_m += distance(last, truth.world_from_base);
    last = truth.world_from_base;
    truths.add({truth.stamp, truth.world_from_base, truth.twist, {}, {}});
    if (output.image && !driver.done()) waiting.push_back(*output.image);
    if (output.ticks) {
      if (const auto odometry = wheels.addTicks(output.stamp, output.ticks->left, output.ticks->right)) {
        buffer.add(*odometry);
        simulator.setCommand(driver.command(odometry->odom_from_base));
      }
    }
    while (!waiting.empty() && buffer.covers(waiting.front().stamp) && truths.covers(waiting.front().stamp)) {
      const Stamp stamp = waiting.front().stamp;
      recording.images.push_back(
          {stamp, waiting.front().bgr, truths.at(stamp)->odom_from_base, buffer.at(stamp)->odom_from_base});
      waiting.pop_front();
    }
    if (!waiting.empty() && !buffer.empty() && waiting.front().stamp < buffer.newest().stamp &&
        !buffer.covers(waiting.front().stamp))
      waiting.pop_front();  // from before the first ticks
    if (toSeconds(simulator.stamp() - sim::kStartTime) > limit_s)
      throw std::runtime_error("the driver did not finish its legs");
  }
  recording.contacts = simulator.contactCount();
  return recording;
}

VisualDriveResult runVisualOdometry(const DriveRecording& recording, const VisualOdometryParams& params) {
  VisualOdometry odometry(params, recording.camera, recording.base_from_camera);
  VisualCloud cloud;
  VisualDriveResult result;
  int tracked = 0;
  const double begin_s = processorSeconds();
  for (const DriveImage& image : recording.images) {
    VisualInput input;
    input.stamp = image.stamp;
    input.image = image.bgr;
    input.odom_from_base = toIsometry(image.odom_from_base);
    VisualOdometryOutput output = odometry.process(input);
    cloud.add(output.retired);
    tracked += output.status.state == VisualState::kTracking ? 1 : 0;
    result.visual.push_back(toPose2(output.odom_from_base));
    result.outputs.push_back(std::move(output));
  }
  const double count = static_cast<double>(std::max<std::size_t>(1, recording.images.size()));
  result.mean_ms = 1000.0 * (processorSeconds() - begin_s) / count;
  result.tracked_share = tracked / count;
  result.cloud = cloud.points();
  if (!recording.images.empty()) {
    const DriveImage& end = recording.images.back();
    result.final_error_m = distance(result.visual.back(), end.world_from_base);
    result.final_wheel_error_m = distance(end.odom_from_base, end.world_from_base);
  }
  return result;
}

}  // namespace frugal_nav::eval
