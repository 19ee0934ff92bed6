#include "camera_drive.hpp"

#include <algorithm>
#include <cmath>

#include <frugal_nav/sim/people.hpp>

namespace frugal_nav::eval {
namespace {

constexpr Duration kSamplePeriod = std::chrono::milliseconds(100);
constexpr double kStanding_mps = 0.01;
constexpr double kStanding_radps = 0.05;

/// Lets the walker set out so that he steps into the robot's lane when the robot is `lead_m` before his line.
class WalkerTrigger {
 public:
  explicit WalkerTrigger(const std::optional<Crossing>& crossing) : crossing_(crossing) {}

  void update(const Pose2& world_from_base, double speed_mps, sim::Simulator& simulator) {
    if (!crossing_ || started_) return;
    constexpr double kHalfLane_m = 0.4;
    const double walk_m = std::max(0.0, std::abs(world_from_base.y_m - crossing_->from_y_m) - kHalfLane_m);
    const double robot_m = speed_mps * walk_m / crossing_->speed_mps;
    if (crossing_->x_m - world_from_base.x_m > crossing_->lead_m + robot_m) return;
    simulator.startPerson(kWalker);
    started_ = true;
  }

 private:
  std::optional<Crossing> crossing_;
  bool started_ = false;
};

/// How long the robot has been standing.
class StandWatch {
 public:
  explicit StandWatch(Stamp begin) : last_moved_(begin) {}
  void add(const Twist2& twist, Stamp stamp) {
    if (std::abs(twist.v_mps) >= kStanding_mps || std::abs(twist.w_radps) >= kStanding_radps)
      last_moved_ = stamp;
  }
  double standing_s(Stamp now) const { return toSeconds(now - last_moved_); }

 private:
  Stamp last_moved_;
};

void addContacts(const std::vector<sim::Contact>& contacts, const StandWatch& stand, Stamp now,
                 CameraDriveRecord& record) {
  constexpr double kHadStood_s = 1.0;
  for (const sim::Contact& contact : contacts) {
    const bool walkers = contact.other == "walker" && stand.standing_s(now) >= kHadStood_s;
    if (record.contacts++ == 0) record.touched = contact.other;
    if (walkers) ++record.walked_into;
  }
}

void sample(const sim::Simulator& simulator, const CameraLayout& layout, const CameraDriver& driver,
            CameraDriveRecord& record) {
  const Pose2 truth = simulator.groundTruth().world_from_base;
  if (!record.truth.empty()) record.length_m += distance(record.truth.back(), truth);
  record.truth.push_back(truth);
  record.believed.push_back(layout.start * driver.odometry());
  const auto& people = simulator.scene().people;
  if (people.size() > kWalker) {
    const double now_s = toSeconds(simulator.stamp() - sim::kStartTime);
    record.walker.push_back(sim::personMotion(people[kWalker], now_s).world_from_person.position());
  }
}

}  // namespace

CameraDriveRecord driveCamera(sim::Simulator& simulator, const CameraLayout& layout, CameraDriver& driver,
                              double speed_mps, double time_limit_s) {
  CameraDriveRecord record;
  record.outcome = "time_out";
  WalkerTrigger walker(layout.crossing);
  const Stamp begin = simulator.stamp();
  StandWatch stand(begin);
  while (toSeconds(simulator.stamp() - begin) < time_limit_s) {
    const sim::SimOutput output = simulator.step();
    addContacts(output.contacts, stand, output.stamp, record);
    const sim::GroundTruth truth = simulator.groundTruth();
    stand.add(truth.twist, output.stamp);
    if (output.image) driver.addImage(*output.image);
    if (output.ticks) simulator.setCommand(driver.addTicks(*output.ticks));
    if ((output.stamp - begin) % kSamplePeriod == Duration::zero()) {
      sample(simulator, layout, driver, record);
      walker.update(truth.world_from_base, speed_mps, simulator);
    }
    record.reason = driver.abortReason();
    if (record.contacts > 0)
      record.outcome = "contact";
    else if (driver.reached())
      record.outcome = "reached";
    else if (!record.reason.empty())
      record.outcome = "aborted";
    else
      continue;
    break;
  }
  sample(simulator, layout, driver, record);
  if (record.reason.empty()) record.reason = driver.activity();
  record.time_s = toSeconds(simulator.stamp() - begin);
  record.goal_error_m = (record.truth.back().position() - layout.p_stand_off).norm();
  return record;
}

}  // namespace frugal_nav::eval
