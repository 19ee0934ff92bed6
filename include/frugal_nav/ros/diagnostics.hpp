#pragma once

#include <cstdint>
#include <map>
#include <string>

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>
#include <ros/timer.h>

#include <frugal_nav/common/time.hpp>

namespace frugal_nav {

/// What one input of a node has done, counted for its diagnostics.
class InputCounter {
 public:
  /// One message came and was used; `now` is ROS time, `stamp` the message's: their difference is the
  /// latency.
  void received(Stamp stamp, Stamp now);
  /// One message came too late or too early to be used (stale, no odometry or transform in time).
  void dropped(const std::string& reason);
  /// One message was bad (NaN, wrong size, out of range).
  void refused(const std::string& reason);

  std::uint64_t receivedCount() const { return received_; }
  std::uint64_t droppedCount() const { return dropped_; }
  std::uint64_t refusedCount() const { return refused_; }

 private:
  friend class NodeDiagnostics;
  std::uint64_t received_ = 0;
  std::uint64_t dropped_ = 0;
  std::uint64_t refused_ = 0;
  std::uint64_t received_at_last_report_ = 0;
  std::uint64_t faults_at_last_report_ = 0;
  double latency_sum_s_ = 0.0;
  double latency_max_s_ = 0.0;
  std::string last_fault_;
};

/// REP-107 diagnostics of a node: per input its rate, latency and counts; per node a status and any numbers.
/// Published once a second. Every count is also there when it is zero.
class NodeDiagnostics {
 public:
  NodeDiagnostics(const ros::NodeHandle& nh, const ros::NodeHandle& pnh);

  /// The counter of an input, made on first use.
  InputCounter& input(const std::string& topic) { return inputs_[topic]; }
  /// A number or text shown beside the inputs.
  void set(const std::string& key, const std::string& value) { values_[key] = value; }
  void set(const std::string& key, double value);
  /// The node's own status line; OK with "running" until it is told otherwise.
  void status(diagnostic_msgs::DiagnosticStatus::_level_type level, const std::string& message);

 private:
  void report(diagnostic_updater::DiagnosticStatusWrapper& out);

  diagnostic_updater::Updater updater_;
  std::map<std::string, InputCounter> inputs_;
  std::map<std::string, std::string> values_;
  diagnostic_msgs::DiagnosticStatus::_level_type level_ = diagnostic_msgs::DiagnosticStatus::OK;
  std::string message_ = "running";
  ros::Time last_report_;
  ros::Timer timer_;
};

}  // namespace frugal_nav
