#include "lidar_drive.hpp"

#include <algorithm>
#include <cmath>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/sim/contact_world.hpp>

namespace frugal_nav::eval {
namespace {

// Clearances beyond this are not told apart: nothing drives that far from everything.
constexpr double kFarthest_m = 1.0;
// Turn rates below this are no turn: the noise of a straight drive.
constexpr double kTurning_radps = 0.1;
constexpr Duration kSamplePeriod = std::chrono::milliseconds(100);

/// Counts how often the robot turns the other way.
class TurnCounter {
 public:
  void add(double w_radps) {
    if (std::abs(w_radps) < kTurning_radps) return;
    const bool left = w_radps > 0.0;
    if (turned_ && left != was_left_) ++changes_;
    turned_ = true;
    was_left_ = left;
  }
  int changes() const { return changes_; }

 private:
  bool turned_ = false;
  bool was_left_ = false;
  int changes_ = 0;
};

void addContacts(const std::vector<sim::Contact>& contacts, DriveRecord& record) {
  for (const sim::Contact& contact : contacts) {
    record.min_clearance_m = 0.0;
    if (!contact.driven_into) continue;
    if (record.contacts++ == 0) record.touched = contact.robot_link + " on " + contact.other;
  }
}

}  // namespace

std::ofstream openCsv(const std::filesystem::path& path, const char* header) {
  std::ofstream file(path);
  if (!file) throw ConfigError("cannot write " + path.string());
  file << header << "\n";
  return file;
}

void writeTrajectory(const std::filesystem::path& path, const std::vector<sim::GroundTruth>& trajectory) {
  std::ofstream file = openCsv(path, "time_s,x_m,y_m,yaw_rad");
  for (const sim::GroundTruth& truth : trajectory) {
    const Pose2& pose = truth.world_from_base;
    file << toSeconds(truth.stamp) << "," << pose.x_m << "," << pose.y_m << "," << pose.yaw_rad << "\n";
  }
}

DriveRecord drive(sim::Simulator& simulator, Driver& driver, double time_limit_s,
                  const std::function<void()>& before_step) {
  DriveRecord record;
  record.min_clearance_m = kFarthest_m;
  sim::ContactWorld contact_world(simulator.scene(), simulator.robot());
  TurnCounter turns;
  const Stamp begin = simulator.stamp();
  Pose2 last = simulator.groundTruth().world_from_base;
  record.outcome = "time_out";
  while (toSeconds(simulator.stamp() - begin) < time_limit_s) {
    before_step();
    const sim::SimOutput output = simulator.step();
    addContacts(output.contacts, record);
    if (output.ticks) simulator.setCommand(driver.addTicks(*output.ticks));
    if (output.scan) simulator.setCommand(driver.addScan(*output.scan));
    if ((output.stamp - begin) % kSamplePeriod == Duration::zero()) {
      const sim::GroundTruth truth = simulator.groundTruth();
      record.trajectory.push_back(truth);
      record.length_m += distance(last, truth.world_from_base);
      last = truth.world_from_base;
      turns.add(truth.twist.w_radps);
      for (const sim::Proximity& near : contact_world.near(truth.world_from_base, record.min_clearance_m))
        record.min_clearance_m = std::max(0.0, std::min(record.min_clearance_m, near.distance_m));
    }
    if (driver.reached()) {
      record.outcome = "reached";
      break;
    }
    record.reason = driver.abortReason();
    if (!record.reason.empty()) {
      record.outcome = "aborted";
      break;
    }
    if (record.contacts > 0 && driver.stopsAtContact()) break;
  }
  if (record.contacts > 0) record.outcome = "contact";
  record.time_s = toSeconds(simulator.stamp() - begin);
  record.turn_sign_changes = turns.changes();
  return record;
}

}  // namespace frugal_nav::eval
