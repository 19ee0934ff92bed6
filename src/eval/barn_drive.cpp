#include "barn_drive.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <frugal_nav/sim/contact_world.hpp>

namespace frugal_nav::eval {
namespace {

// The reference path is driven at this speed in the best possible time.
constexpr double kOptimal_mps = 2.0;
constexpr double kSlowest = 8.0;  // times of more than this many best ones are scored alike
constexpr double kFarthest_m = 1.0;
constexpr Duration kSamplePeriod = std::chrono::milliseconds(100);

/// What the base makes of the commands it gets.
class BarnBase {
 public:
  BarnBase(double max_v_mps, const BarnRules& rules) : max_v_mps_(max_v_mps), rules_(rules) {}

  Twist2 follow(const Twist2& command) {
    const double period_s = 1.0 / rules_.control_hz;
    const double dv = rules_.accel_mps2 * period_s;
    const double dw = rules_.turn_accel_radps2 * period_s;
    const double v = std::clamp(command.v_mps, -max_v_mps_, max_v_mps_);
    const double w = std::clamp(command.w_radps, -rules_.max_w_radps, rules_.max_w_radps);
    present_ = {std::clamp(v, present_.v_mps - dv, present_.v_mps + dv),
                std::clamp(w, present_.w_radps - dw, present_.w_radps + dw)};
    return present_;
  }

 private:
  double max_v_mps_;
  BarnRules rules_;
  Twist2 present_;
};

}  // namespace

double barnScore(bool success, double time_s, double path_length_m, double k) {
  if (!success) return 0.0;
  const double optimal_s = path_length_m / kOptimal_mps;
  return optimal_s / std::clamp(time_s, k * optimal_s, kSlowest * optimal_s);
}

DriveRecord driveBarn(sim::Simulator& simulator, Driver& driver, const Eigen::Vector2d& p_world_goal,
                      double max_v_mps, const BarnRules& rules) {
  DriveRecord record;
  record.outcome = "time_out";
  record.min_clearance_m = kFarthest_m;
  sim::ContactWorld contact_world(simulator.scene(), simulator.robot());
  BarnBase base(max_v_mps, rules);
  Twist2 command;
  std::optional<LaserScan> scan;  // the newest that no command rests on yet
  const Pose2 start = simulator.groundTruth().world_from_base;
  const Duration control_period = fromSeconds(1.0 / rules.control_hz);
  const Stamp begin = simulator.stamp();
  Stamp clock_start = begin;
  bool started = false;
  Pose2 last = start;
  while (toSeconds(simulator.stamp() - clock_start) < rules.time_limit_s) {
    const sim::SimOutput output = simulator.step();
    if (output.ticks) command = driver.addTicks(*output.ticks);
    if (output.scan) scan = output.scan;
    if ((output.stamp - begin) % control_period == Duration::zero() && scan) {
      command = driver.addScan(*scan);
      simulator.setCommand(base.follow(command));
      scan.reset();
    }
    const Pose2 pose = simulator.groundTruth().world_from_base;
    if (!started && distance(start, pose) > rules.clock_starts_m) {
      started = true;
      clock_start = output.stamp;
    }
    if ((output.stamp - begin) % kSamplePeriod == Duration::zero()) {
      record.trajectory.push_back(simulator.groundTruth());
      record.length_m += distance(last, pose);
      last = pose;
      for (const sim::Proximity& near : contact_world.near(pose, record.min_clearance_m))
        record.min_clearance_m = std::max(0.0, std::min(record.min_clearance_m, near.distance_m));
    }
    record.contacts += static_cast<int>(output.contacts.size());
    if (record.contacts > 0) {
      record.outcome = "contact";
      record.touched = output.contacts.front().other;
      break;
    }
    if ((pose.position() - p_world_goal).norm() <= rules.goal_radius_m) {
      record.outcome = "reached";
      break;
    }
    record.reason = driver.abortReason();
    if (!record.reason.empty()) {
      record.outcome = "aborted";
      break;
    }
  }
  record.time_s = toSeconds(simulator.stamp() - clock_start);
  return record;
}

}  // namespace frugal_nav::eval
