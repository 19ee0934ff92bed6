#include <algorithm>
#include <sstream>

#include <frugal_nav/ros/diagnostics.hpp>

namespace frugal_nav {

void InputCounter::received(Stamp stamp, Stamp now) {
  ++received_;
  const double latency_s = toSeconds(now - stamp);
  latency_sum_s_ += latency_s;
  latency_max_s_ = std::max(latency_max_s_, latency_s);
}

void InputCounter::dropped(const std::string& reason) {
  ++dropped_;
  last_fault_ = reason;
}

void InputCounter::refused(const std::string& reason) {
  ++refused_;
  last_fault_ = reason;
}

NodeDiagnostics::NodeDiagnostics(const ros::NodeHandle& nh, const ros::NodeHandle& pnh) : updater_(nh, pnh) {
  updater_.setHardwareID("none");
  updater_.add("status", this, &NodeDiagnostics::report);
  timer_ = nh.createTimer(ros::Duration(1.0), [this](const ros::TimerEvent&) { updater_.force_update(); });
}

void NodeDiagnostics::set(const std::string& key, double value) {
  std::ostringstream text;
  text << value;
  values_[key] = text.str();
}

void NodeDiagnostics::status(diagnostic_msgs::DiagnosticStatus::_level_type level,
                             const std::string& message) {
  level_ = level;
  message_ = message;
}

void NodeDiagnostics::report(diagnostic_updater::DiagnosticStatusWrapper& out) {
  const ros::Time now = ros::Time::now();
  const double span_s = last_report_.isZero() ? 0.0 : (now - last_report_).toSec();
  last_report_ = now;
  out.summary(level_, message_);
  for (auto& [topic, counter] : inputs_) {
    const std::uint64_t fresh = counter.received_ - counter.received_at_last_report_;
    const std::uint64_t faults = counter.dropped_ + counter.refused_;
    if (span_s > 0.0) out.addf(topic + " rate [Hz]", "%.1f", static_cast<double>(fresh) / span_s);
    if (fresh > 0) {
      out.addf(topic + " mean latency [s]", "%.3f", counter.latency_sum_s_ / static_cast<double>(fresh));
      out.addf(topic + " max latency [s]", "%.3f", counter.latency_max_s_);
    }
    out.add(topic + " received", counter.received_);
    out.add(topic + " dropped", counter.dropped_);
    out.add(topic + " refused", counter.refused_);
    if (!counter.last_fault_.empty()) out.add(topic + " last fault", counter.last_fault_);
    if (faults > counter.faults_at_last_report_) {
      out.mergeSummary(diagnostic_msgs::DiagnosticStatus::WARN, topic + ": " + counter.last_fault_);
    }
    counter.received_at_last_report_ = counter.received_;
    counter.faults_at_last_report_ = faults;
    counter.latency_sum_s_ = counter.latency_max_s_ = 0.0;
  }
  for (const auto& [key, value] : values_) out.add(key, value);
}

}  // namespace frugal_nav
