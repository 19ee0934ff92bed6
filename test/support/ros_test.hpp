#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include <ros/callback_queue.h>
#include <ros/network.h>
#include <ros/ros.h>
#include <ros/xmlrpc_manager.h>
#include <rosgraph_msgs/Clock.h>
#include <sys/wait.h>
#include <unistd.h>
#include <xmlrpcpp/XmlRpc.h>

// Helpers of the node tests. Nothing sleeps for a guessed time: callbacks are pumped until a condition holds,
// and a deadline of wall time only bounds how long a failure takes. Simulated time stands still but for
// advance().

namespace frugal_nav::test {

/// Pumps callbacks until the condition holds; false when it still does not after the deadline.
inline bool waitUntil(const std::function<bool()>& condition, double wall_deadline_s = 10.0) {
  const ros::WallTime deadline = ros::WallTime::now() + ros::WallDuration(wall_deadline_s);
  while (ros::ok()) {
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.001));
    if (condition()) return true;
    if (ros::WallTime::now() > deadline) return false;
  }
  return false;
}

namespace ros_test_detail {

/// Rows of a node's getBusInfo: id, other end, direction, transport, topic, connected, the transport's words.
constexpr int kOtherEnd = 1, kDirection = 2, kTopic = 4, kTransportInfo = 6;

/// The rows that a node's getBusInfo has for one topic and direction ("i" in, "o" out).
inline std::vector<XmlRpc::XmlRpcValue> connections(const std::string& node_uri, const std::string& topic,
                                                    const std::string& direction) {
  std::vector<XmlRpc::XmlRpcValue> found;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(node_uri, host, port)) return found;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue request, response;
  request[0] = ros::this_node::getName();
  if (!client.execute("getBusInfo", request, response) || response.size() < 3) return found;
  XmlRpc::XmlRpcValue& rows = response[2];
  for (int i = 0; i < rows.size(); ++i) {
    if (rows[i].size() > kTransportInfo && std::string(rows[i][kDirection]) == direction &&
        std::string(rows[i][kTopic]) == topic) {
      found.push_back(rows[i]);
    }
  }
  return found;
}

/// Whether the publisher's end of a connection is in place: from then on no message is lost. A connection
/// before it, not yet known to be closed, has another port.
inline bool isServed(XmlRpc::XmlRpcValue& incoming, const std::string& topic) {
  const std::string transport = incoming[kTransportInfo];
  const std::string before = "on port ";
  const std::size_t at = transport.find(before);
  if (at == std::string::npos) return true;  // within this process
  const std::string digits = transport.substr(at + before.size());
  const std::string port = ":" + digits.substr(0, digits.find(' ')) + " ";
  for (XmlRpc::XmlRpcValue& outgoing : connections(std::string(incoming[kOtherEnd]), topic, "o")) {
    if (std::string(outgoing[kOtherEnd]) == ros::this_node::getName() &&
        std::string(outgoing[kTransportInfo]).find(port) != std::string::npos) {
      return true;
    }
  }
  return false;
}

/// Whether every publisher that this node is linked to serves it, and there is one.
inline bool isServed(const std::string& topic) {
  std::vector<XmlRpc::XmlRpcValue> links =
      connections(ros::XMLRPCManager::instance()->getServerURI(), topic, "i");
  return !links.empty() && std::all_of(links.begin(), links.end(),
                                       [&](XmlRpc::XmlRpcValue& link) { return isServed(link, topic); });
}

/// Whether a node is on this node's list of those that listen to a topic.
inline bool isHeardBy(const std::string& topic, const std::string& node) {
  std::vector<XmlRpc::XmlRpcValue> links =
      connections(ros::XMLRPCManager::instance()->getServerURI(), topic, "o");
  return std::any_of(links.begin(), links.end(),
                     [&](XmlRpc::XmlRpcValue& link) { return std::string(link[kOtherEnd]) == node; });
}

}  // namespace ros_test_detail

/// Waits until someone publishes what a subscriber listens to, and will lose none of it: the subscriber's own
/// count rises before the publisher knows of it.
inline bool waitForPublisher(const ros::Subscriber& subscriber) {
  return waitUntil([&subscriber] {
    return subscriber.getNumPublishers() > 0 && ros_test_detail::isServed(subscriber.getTopic());
  });
}

/// Collects the messages of a topic.
template <class Message>
class Recorder {
 public:
  Recorder(ros::NodeHandle& nh, const std::string& topic)
      : subscriber_(nh.subscribe<Message>(
            topic, 1000, [this](const boost::shared_ptr<const Message>& msg) { messages.push_back(*msg); })) {
  }

  /// Waits until someone publishes the topic, and will lose none of its messages.
  bool waitForPublisher() { return test::waitForPublisher(subscriber_); }
  /// Waits until at least `count` messages have come.
  bool waitForCount(std::size_t count, double wall_deadline_s = 10.0) {
    return waitUntil([&] { return messages.size() >= count; }, wall_deadline_s);
  }

  std::vector<Message> messages;

 private:
  ros::Subscriber subscriber_;
};

/// Waits for the answer to the sensor message of that stamp; null when none comes.
template <class Message>
const Message* answerAt(const Recorder<Message>& recorder, ros::Time stamp) {
  const Message* found = nullptr;
  waitUntil([&] {
    for (const Message& message : recorder.messages) {
      if (message.header.stamp == stamp) found = &message;
    }
    return found != nullptr;
  });
  return found;
}

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
  /// Waits until a node listens; this process itself always does.
  bool waitForNode(const std::string& node) {
    const std::string name = ros::names::resolve(node);
    return waitUntil([&name] { return ros_test_detail::isHeardBy("/clock", name); });
  }
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
