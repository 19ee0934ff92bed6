#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <frugal_nav/common/geometry.hpp>
#include <frugal_nav/common/laser_scan.hpp>
#include <frugal_nav/sim/simulator.hpp>

namespace frugal_nav::eval {

/// What drives a robot in a trial: it takes the sensors' data and gives velocities.
class Driver {
 public:
  virtual ~Driver() = default;
  Driver() = default;
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  virtual Twist2 addTicks(const sim::WheelTicks& ticks) = 0;
  virtual Twist2 addScan(const LaserScan& scan) = 0;
  /// Where its odometry says it is, in the frame of the start.
  virtual Pose2 odometry() const = 0;
  virtual bool reached() const = 0;
  /// Why it gave up; empty while it has not.
  virtual std::string abortReason() const = 0;
  virtual bool stopsAtContact() const { return false; }
  virtual int recoveries() const { return 0; }
};

/// What came of a drive.
struct DriveRecord {
  std::string outcome;  ///< "reached", "aborted", "time_out" or "contact"
  std::string reason;
  int contacts = 0;     ///< times the robot drove into something
  std::string touched;  ///< what it drove into first
  double time_s = 0.0;
  double length_m = 0.0;
  double min_clearance_m = 0.0;  ///< smallest distance between the robot and anything; 0 when it touched
  int turn_sign_changes = 0;
  std::vector<sim::GroundTruth> trajectory;  ///< ten a second
};

/// A CSV file of its own for trajectories and outlines, with its header line; throws ConfigError.
std::ofstream openCsv(const std::filesystem::path& path, const char* header);
/// The places a robot went as a CSV file; throws ConfigError.
void writeTrajectory(const std::filesystem::path& path, const std::vector<sim::GroundTruth>& trajectory);

/// Lets a driver drive until it is at the goal, gives up, or the time is over. `before_step` moves what moves
/// by itself.
DriveRecord drive(
    sim::Simulator& simulator, Driver& driver, double time_limit_s,
    const std::function<void()>& before_step = [] {});

}  // namespace frugal_nav::eval
