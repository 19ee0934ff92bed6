#include "marker_drive.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>

#include <frugal_nav/eval/visual_drive.hpp>
#include <frugal_nav/localization/marker_localization.hpp>

namespace frugal_nav::eval {
namespace {

constexpr double kStanding_s = 3.0;  // before the first goal
constexpr double kUncovered_s = 12.0;
constexpr double kCovered_s = 10.0;
constexpr double kCoverEvery_s = 25.0;
constexpr double kLeastWay_m = 1.0;  // of a drift: less is mostly the error it began with
constexpr double kFlip_rad = 20.0 * M_PI / 180.0;

sim::SimulatorParams simulatorParams(const MarkerHall& hall, const MarkerDriveParams& params) {
  sim::SimulatorParams simulator;
  simulator.sensors = {true, true, true, true, false};
  simulator.camera.rate_hz = params.image_rate_hz;
  simulator.camera.threads = 1;  // trials run side by side
  simulator.lighting.setting = hall.light;
  return simulator;
}

/// The same filter with images that come late.
class DelayedLocalization {
 public:
  DelayedLocalization(const MarkerLocalizationParams& params, const MarkerMap& map, double delay_s)
      : filter(params, map), delay_(fromSeconds(delay_s)) {}

  void addImage(const MarkerCamera& taken, const MarkerFindings& findings, bool is_near) {
    waiting_.push_back({taken, findings, is_near});
  }
  /// Whether an image with a marker near enough came in.
  bool deliver(Stamp now) {
    bool is_near = false;
    for (; !waiting_.empty() && waiting_.front().taken.stamp + delay_ <= now; waiting_.pop_front()) {
      filter.addCorners(waiting_.front().taken, waiting_.front().findings, now);
      is_near = waiting_.front().is_near;
    }
    return is_near;
  }

  MarkerLocalization filter;

 private:
  struct Late {
    MarkerCamera taken;
    MarkerFindings findings;
    bool is_near;
  };
  Duration delay_;
  std::deque<Late> waiting_;
};

class MarkerDrive {
 public:
  MarkerDrive(const MarkerHall& hall, const RobotModel& robot, const MarkerStackParams& stack,
              const MarkerDriveParams& params, std::uint64_t seed)
      : hall_(hall),
        params_(params),
        simulator_(hall.scene, robot, simulatorParams(hall, params), seed, hall.start),
        camera_{{}, pinholeOf(simulator_.camera()), robot.baseFrom("camera_optical_frame")},
        gyro_axis_(robot.baseFrom("imu_link").linear().row(2).transpose()),
        stack_(stack.drive, robot),
        ours_(stack.localization, hall.map),
        delayed_(stack.localization, hall.map, params.image_delay_s),
        printed_(params.as_printed, hall.map, camera_.camera, camera_.base_from_optical, hall.start),
        period_(fromSeconds(1.0 / params.image_rate_hz)),
        time_limit_s_(kStanding_s + 30.0 + 3.0 * hall.tour_m / stack.drive.base.limits.max_v_mps) {}

  MarkerDriveRecord run() {
    record_.outcome = "time_out";
    Pose2 last = hall_.start;
    while (time_s() < time_limit_s_ && record_.outcome == "time_out") {
      const sim::SimOutput output = simulator_.step();
      truth_ = simulator_.groundTruth().world_from_base;
      record_.length_m += distance(last, truth_);
      last = truth_;
      takeContacts(output);
      if (output.imu) takeGyro(*output.imu);
      if (output.ticks) takeTicks(*output.ticks);
      if (output.scan) command(stack_.addScan(*output.scan));
      const bool is_near = output.image && takeImage(*output.image);
      const bool is_late_near = delayed_.deliver(simulator_.stamp());
      if (const auto late = delayed_.filter.estimateAt(simulator_.stamp()); late && is_late_near)
        record_.delayed.add(*late, truth_);
      const bool is_due = (simulator_.stamp() - sim::kStartTime) % period_ == Duration::zero();
      if (output.image || (is_covered_ && is_due)) sample(is_near);
      cover();
      decide();
    }
    record_.time_s = time_s();
    return std::move(record_);
  }

 private:
  double time_s() const { return toSeconds(simulator_.stamp() - sim::kStartTime); }

  void command(const BaseCommand& told) {
    commanded_mps_ = told.velocity.v_mps;
    simulator_.setCommand(told.velocity);
  }

  void takeContacts(const sim::SimOutput& output) {
    for (const sim::Contact& contact : output.contacts) {
      if (record_.contacts++ == 0) record_.touched = contact.robot_link + " on " + contact.other;
    }
  }

  void takeGyro(const sim::ImuSample& imu) {
    const double rate = gyro_axis_.dot(imu.angular_velocity_radps);
    ours_.addGyro(imu.stamp, rate, imu.stamp);
    delayed_.filter.addGyro(imu.stamp, rate, imu.stamp);
    printed_.addGyro(imu.stamp, rate);
  }

  void takeTicks(const sim::WheelTicks& ticks) {
    printed_.predict(ticks.stamp, commanded_mps_);
    command(stack_.addTicks(ticks.stamp, ticks.left, ticks.right));
    const Odometry& odometry = stack_.odometry();
    if (odometry.stamp != ticks.stamp) return;
    map_pose_ = ours_.addOdometry(odometry, ticks.stamp).pose;
    if (map_pose_ && tour_start_s_) stack_.moveGoal(goal());
    delayed_.filter.addOdometry(odometry, ticks.stamp);
  }

  /// Whether it shows a marker near enough.
  bool takeImage(const sim::CameraImage& image) {
    camera_.stamp = image.stamp;
    const MarkerImageResult result = ours_.addImage(camera_, image.bgr, image.stamp);
    MarkerFindings findings;
    for (const MarkerSighting& sighting : result.fix.sightings) findings.markers.push_back(sighting.corners);
    printed_.correct(detectAsPrinted(image.bgr, hall_.map.dictionary));
    ++record_.images;
    if (result.isUsed()) {
      ++record_.fixes;
      const double yaw_error = angleBetween(truth_.yaw_rad, result.fix.map_from_base.yaw_rad);
      if (std::abs(yaw_error) > kFlip_rad) ++record_.flips;
    }
    const Eigen::Isometry3d map_from_optical = toIsometry(truth_) * camera_.base_from_optical;
    const bool is_near =
        std::any_of(hall_.map.markers.begin(), hall_.map.markers.end(), [&](const auto& entry) {
          return isInView(entry.second, camera_.camera, map_from_optical, params_.near_m,
                          simulator_.tracer());
        });
    delayed_.addImage(camera_, findings, is_near);
    return is_near;
  }

  void sample(bool is_near) {
    const std::optional<PoseEstimate> ours = ours_.estimateAt(simulator_.stamp());
    if (!ours) return;
    record_.all.add(*ours, truth_);
    if (is_near) {
      record_.near.add(*ours, truth_);
      record_.printed.add(printed_.mapFromBase(), truth_);
    }
    record_.samples.push_back({time_s(), truth_, ours->map_from_base, printed_.mapFromBase(),
                               std::sqrt(ours->covariance.topLeftCorner<2, 2>().trace()), is_near});
  }

  /// Covers and uncovers the camera; tells how far the pose has drifted meanwhile.
  void cover() {
    const double since_s = tour_start_s_ ? time_s() - *tour_start_s_ : 0.0;
    const double phase_s = std::fmod(since_s, kCoverEvery_s);
    const bool covered = phase_s >= kUncovered_s && phase_s < kUncovered_s + kCovered_s;
    if (covered == is_covered_) return;
    is_covered_ = covered;
    sim::SensorSwitches sensors = simulator_.params().sensors;
    sensors.camera = !covered;
    simulator_.setSensors(sensors);
    if (covered) {
      covered_from_m_ = record_.length_m;
      return;
    }
    const double way_m = record_.length_m - covered_from_m_;
    const auto ours = ours_.estimateAt(simulator_.stamp());
    if (ours && way_m >= kLeastWay_m)
      record_.drift_pct.push_back(100.0 * distance(ours->map_from_base, truth_) / way_m);
  }

  /// What the mission node does with a tour: a waypoint is a goal in odom, moved as the robot learns where it
  /// is, and the next one when it is reached.
  void decide() {
    if (!map_pose_ || time_s() < kStanding_s) return;
    const MissionPhase phase = stack_.mission().status().phase;
    if (tour_start_s_ && phase == MissionPhase::kAborted) {
      record_.outcome = "aborted";
      record_.reason = stack_.mission().status().reason;
    } else if (!tour_start_s_) {
      tour_start_s_ = time_s();
      stack_.setGoal(goal(), simulator_.stamp());
    } else if (phase == MissionPhase::kReached) {
      record_.waypoint_errors_m.push_back((truth_.position() - hall_.waypoints[next_]).norm());
      if (++next_ == hall_.waypoints.size()) {
        record_.outcome = "toured";
      } else {
        stack_.setGoal(goal(), simulator_.stamp());
      }
    }
  }

  /// The waypoint in odom.
  Pose2 goal() const {
    const Eigen::Vector2d& p = hall_.waypoints[next_];
    return map_pose_->map_from_odom.inverse() * Pose2{p.x(), p.y(), 0.0};
  }

  const MarkerHall& hall_;
  const MarkerDriveParams& params_;
  sim::Simulator simulator_;
  MarkerCamera camera_;
  Eigen::Vector3d gyro_axis_;
  LidarStack stack_;
  MarkerLocalization ours_;
  DelayedLocalization delayed_;
  AsPrintedFilter printed_;
  Duration period_;
  double time_limit_s_;

  MarkerDriveRecord record_;
  Pose2 truth_;
  double commanded_mps_ = 0.0;
  std::optional<MapPose> map_pose_;
  std::optional<double> tour_start_s_;
  std::size_t next_ = 0;
  bool is_covered_ = false;
  double covered_from_m_ = 0.0;
};

}  // namespace

MarkerDriveRecord driveMarkerHall(const MarkerHall& hall, const RobotModel& robot,
                                  const MarkerStackParams& stack, const MarkerDriveParams& params,
                                  std::uint64_t seed) {
  return MarkerDrive(hall, robot, stack, params, seed).run();
}

}  // namespace frugal_nav::eval
