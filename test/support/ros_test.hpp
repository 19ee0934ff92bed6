#pragma once

#include <array>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>
#include <sys/wait.h>
#include <unistd.h>

// Helpers of the node tests. Nothing sleeps for a guessed time: callbacks are pumped until a condition holds,
// and a deadline of wall time only bounds how long a failure takes. Simulated time stands still but for
// advance().

namespace frugal_nav::test {

/// Pumps callbacks until the condition holds; false when it still does not after the deadline.
inline bool waitUntil(const std::function<bool()>& condition, double wall_deadline_s = 10.0) {
  const ros::WallTime deadline = ros::WallTime::now() + ros::WallDuration(wall_deadline_s);
  while (ros::ok()) {
    ros::spinOnce();
    if (condition()) return true;
    if (ros::WallTime::now() > deadline) return false;
    ros::WallDuration(0.001).sleep();
  }
  return false;
}

/// Collects the messages of a topic.
template <class Message>
class Recorder {
 public:
  Recorder(ros::NodeHandle& nh, const std::string& topic)
      : subscriber_(nh.subscribe<Message>(
            topic, 1000, [this](const boost::shared_ptr<const Message>& msg) { messages.push_back(*msg); })) {
  }

  /// Waits until someone publishes the topic.
  bool waitForPublisher() {
    return waitUntil([this] { return subscriber_.getNumPublishers() > 0; });
  }
  /// Waits until at least `count` messages have come.
  bool waitForCount(std::size_t count, double wall_deadline_s = 10.0) {
    return waitUntil([&] { return messages.size() >= count; }, wall_deadline_s);
  }

  std::vector<Message> messages;

 private:
  ros::Subscriber subscriber_;
};

/// Waits until someone listens to a publisher.
inline bool waitForSubscriber(const ros::Publisher& publisher) {
  return waitUntil([&publisher] { return publisher.getNumSubscribers() > 0; });
}

/// Simulated time of the test (`use_sim_time` must be set in the .test file).
class TestClock {
 public:
  explicit TestClock(ros::NodeHandle& nh, double start_s = 100.0)
      : publisher_(nh.advertise<rosgraph_msgs::Clock>("/clock", 1000)), now_(start_s) {
    set(now_);
  }

  ros::Time now() const { return now_; }
  void advance(double seconds) { set(now_ + ros::Duration(seconds)); }
  /// Publishes a time, a jump too, and waits until this process has it.
  void set(const ros::Time& time) {
    now_ = time;
    rosgraph_msgs::Clock msg;
    msg.clock = now_;
    publisher_.publish(msg);
    waitUntil([this] { return ros::Time::now() == now_; });
  }

 private:
  ros::Publisher publisher_;
  ros::Time now_;
};

/// How a program ended and what it wrote.
struct ProgramResult {
  int exit_code = -1;  ///< 124: it did not end in time
  std::string output;  ///< of both its streams
};

/// Path of a program of this package: they lie beside the test's own.
inline std::string programPath(const std::string& name) {
  std::array<char, 4096> path{};
  const ssize_t length = readlink("/proc/self/exe", path.data(), path.size() - 1);
  const std::string self(path.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
  return self.substr(0, self.rfind('/') + 1) + name;
}

/// Runs a program of this package until it ends, for at most 20 s.
inline ProgramResult runProgram(const std::string& name, const std::string& arguments = "") {
  ProgramResult result;
  std::FILE* pipe = popen(("timeout 20 '" + programPath(name) + "' " + arguments + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 4096> text{};
  while (std::fgets(text.data(), static_cast<int>(text.size()), pipe) != nullptr)
    result.output += text.data();
  const int status = pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

}  // namespace frugal_nav::test
