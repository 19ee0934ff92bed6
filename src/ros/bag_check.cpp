#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include <ros/serialization.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <std_msgs/Header.h>
#include <tf2_msgs/TFMessage.h>
#include <yaml-cpp/yaml.h>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/ros/bag_check.hpp>

namespace frugal_nav {
namespace {

/// Stamps farther than this from their recording are of another clock [s]; expectations may be narrower.
constexpr double kOtherClock_s = 5.0;

std::string seconds(double value_s) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.3f s", value_s);
  return text;
}

/// A topic's name with one slash in front: bags hold names as the recorder was told them, "scan" or "/scan".
std::string absolute(const std::string& topic) {
  const std::size_t begin = topic.find_first_not_of('/');
  return begin == std::string::npos ? "/" : "/" + topic.substr(begin);
}

/// The header of any message whose definition begins with one.
std::optional<std_msgs::Header> headerOf(const rosbag::MessageInstance& message,
                                         std::vector<std::uint8_t>& buffer) {
  const std::string definition = message.getMessageDefinition();
  std::istringstream lines(definition);
  for (std::string line; std::getline(lines, line);) {
    line.erase(0, line.find_first_not_of(" \t"));
    if (line.empty() || line[0] == '#') continue;
    if (line.substr(0, line.find('#')).find('=') != std::string::npos) continue;  // a constant, no field
    if (line.rfind("Header ", 0) != 0 && line.rfind("std_msgs/Header ", 0) != 0) return std::nullopt;
    buffer.resize(message.size());
    ros::serialization::OStream out(buffer.data(), static_cast<std::uint32_t>(buffer.size()));
    message.write(out);
    ros::serialization::IStream in(buffer.data(), static_cast<std::uint32_t>(buffer.size()));
    std_msgs::Header header;
    ros::serialization::deserialize(in, header);
    return header;
  }
  return std::nullopt;
}

/// Goes through the messages in the order of their recording.
class Checker {
 public:
  Checker(const std::vector<TopicExpectation>& expectations, const std::string& name_space) {
    for (const TopicExpectation& expectation : expectations) {
      const std::string prefix =
          name_space.empty() || name_space.back() != '/' ? name_space + "/" : name_space;
      expected_[prefix + expectation.topic] = expectation;
    }
  }

  void look(const rosbag::MessageInstance& message) {
    const std::string topic = absolute(message.getTopic());
    TopicReport& report = report_.topics[topic];
    if (report.count == 0) {
      report.type = message.getDataType();
      checkType(topic, report);
    } else if (report.type != message.getDataType()) {
      note(topic, "type", message.getTime(),
           "type changes from " + report.type + " to " + message.getDataType());
    }
    if (report.type == "tf2_msgs/TFMessage") lookAtTransforms(message);
    const std::optional<std_msgs::Header> header = headerOf(message, buffer_);
    report.has_header = header.has_value();
    if (header) lookAtHeader(topic, report, *header, message.getTime());
    if (header && header->stamp.isZero()) {
      ++report.count;
    } else {
      advance(topic, report, header ? header->stamp : message.getTime());
    }
  }

  BagReport finish() {
    for (const auto& [topic, expectation] : expected_) checkExpectation(topic, expectation);
    checkFrames();
    for (const auto& [key, problem] : problems_) {
      BagProblem first = problem.first;
      if (problem.count > 1) first.text += " (and " + std::to_string(problem.count - 1) + " more such)";
      report_.problems.push_back(first);
    }
    return std::move(report_);
  }

 private:
  struct Repeated {
    BagProblem first;
    int count = 0;
  };

  /// Notes a problem; of one kind on one topic, the first is told and the others are counted.
  void note(const std::string& topic, const std::string& kind, std::optional<ros::Time> time,
            const std::string& text) {
    Repeated& problem = problems_[topic + " " + kind];
    if (problem.count++ == 0) problem.first = {topic, time, text};
  }

  const TopicExpectation* expectationOf(const std::string& topic) const {
    const auto found = expected_.find(topic);
    return found == expected_.end() ? nullptr : &found->second;
  }

  void checkType(const std::string& topic, const TopicReport& report) {
    const TopicExpectation* expectation = expectationOf(topic);
    if (expectation && !expectation->type.empty() && expectation->type != report.type)
      note(topic, "type", std::nullopt, "is " + report.type + ", expected " + expectation->type);
  }

  void lookAtHeader(const std::string& topic, TopicReport& report, const std_msgs::Header& header,
                    const ros::Time& recorded) {
    const TopicExpectation* expectation = expectationOf(topic);
    if (header.stamp.isZero() && !(expectation && expectation->zero_stamps))
      note(topic, "zero", recorded, "stamp is zero");
    const double delay_s = (recorded - header.stamp).toSec();
    const double allowed_s =
        expectation && expectation->max_delay_s ? *expectation->max_delay_s : kOtherClock_s;
    if (!header.stamp.isZero() && std::abs(delay_s) > allowed_s)
      note(topic, "delay", recorded, "stamp lies " + seconds(delay_s) + " before its recording");
    // The frame of joint states and diagnostics has no meaning either.
    if (report.type == "sensor_msgs/JointState" || report.type == "diagnostic_msgs/DiagnosticArray") return;
    if (expectation && expectation->no_frame) return;
    if (header.frame_id.empty()) {
      note(topic, "no frame", recorded, "frame_id is empty");
    } else if (header.frame_id[0] == '/') {
      note(topic, "slash", recorded,
           "frame_id '" + header.frame_id + "' begins with a slash, which tf2 refuses");
    }
    if (expectation && !expectation->frame.empty() && expectation->frame != header.frame_id)
      note(topic, "frame", recorded,
           "frame_id is '" + header.frame_id + "', expected '" + expectation->frame + "'");
    report.frames.insert(header.frame_id);
  }

  void advance(const std::string& topic, TopicReport& report, const ros::Time& stamp) {
    if (!report.last.isZero()) {
      const double step_s = (stamp - report.last).toSec();
      const TopicExpectation* expectation = expectationOf(topic);
      if (step_s < 0.0 && !(expectation && expectation->unordered_stamps))
        note(topic, "back", stamp, "stamp goes back by " + seconds(-step_s));
      if (step_s == 0.0 && report.has_header && expectation && !expectation->repeated_stamps)
        note(topic, "same", stamp, "stamp comes twice");
      if (expectation && expectation->max_gap_s && step_s > *expectation->max_gap_s)
        note(topic, "gap", stamp,
             "gap of " + seconds(step_s) + " before it, allowed " + seconds(*expectation->max_gap_s));
      report.max_gap_s = std::max(report.max_gap_s, step_s);
    } else {
      report.first = stamp;
    }
    report.last = stamp;
    ++report.count;
  }

  void lookAtTransforms(const rosbag::MessageInstance& message) {
    const auto transforms = message.instantiate<tf2_msgs::TFMessage>();
    if (!transforms) return;
    for (const auto& transform : transforms->transforms) {
      const std::string& child = transform.child_frame_id;
      const auto known = parents_.emplace(child, transform.header.frame_id);
      if (!known.second && known.first->second != transform.header.frame_id)
        note(absolute(message.getTopic()), "parents", message.getTime(),
             "frame '" + child + "' has two parents: '" + known.first->second + "' and '" +
                 transform.header.frame_id + "'");
      tf_frames_.insert(child);
      tf_frames_.insert(transform.header.frame_id);
    }
  }

  void checkExpectation(const std::string& topic, const TopicExpectation& expectation) {
    const auto found = report_.topics.find(topic);
    if (found == report_.topics.end()) {
      if (expectation.required) note(topic, "missing", std::nullopt, "is missing");
      return;
    }
    const double rate = found->second.rate_hz();
    std::ostringstream text;
    text.precision(3);
    if (expectation.min_rate_hz && rate < *expectation.min_rate_hz)
      text << "rate is " << rate << " Hz, expected at least " << *expectation.min_rate_hz << " Hz";
    if (expectation.max_rate_hz && rate > *expectation.max_rate_hz)
      text << "rate is " << rate << " Hz, expected at most " << *expectation.max_rate_hz << " Hz";
    if (!text.str().empty()) note(topic, "rate", std::nullopt, text.str());
  }

  void checkFrames() {
    for (const auto& [topic, report] : report_.topics) {
      if (report.frames.size() > 1) {
        note(topic, "frames", std::nullopt,
             "frame_id changes: '" + *report.frames.begin() + "', '" + *report.frames.rbegin() + "'");
      }
      for (const std::string& frame : report.frames) {
        if (!tf_frames_.empty() && !frame.empty() && tf_frames_.count(frame) == 0)
          note(topic, "unknown frame " + frame, std::nullopt, "frame '" + frame + "' is not in the bag's tf");
      }
    }
  }

  std::map<std::string, TopicExpectation> expected_;
  BagReport report_;
  std::map<std::string, Repeated> problems_;
  std::map<std::string, std::string> parents_;
  std::set<std::string> tf_frames_;
  std::vector<std::uint8_t> buffer_;
};

BagReport unreadable(BagReport report, const std::string& text) {
  report.problems.insert(report.problems.begin(), {"", std::nullopt, text});
  return report;
}

TopicExpectation parseExpectation(const YAML::Node& node, const std::string& where) {
  TopicExpectation expectation;
  for (const auto& item : node) {
    const auto key = item.first.as<std::string>();
    const YAML::Node& value = item.second;
    if (key == "topic") {
      expectation.topic = value.as<std::string>();
    } else if (key == "type") {
      expectation.type = value.as<std::string>();
    } else if (key == "frame") {
      expectation.frame = value.as<std::string>();
    } else if (key == "required") {
      expectation.required = value.as<bool>();
    } else if (key == "zero_stamps") {
      expectation.zero_stamps = value.as<bool>();
    } else if (key == "no_frame") {
      expectation.no_frame = value.as<bool>();
    } else if (key == "repeated_stamps") {
      expectation.repeated_stamps = value.as<bool>();
    } else if (key == "unordered_stamps") {
      expectation.unordered_stamps = value.as<bool>();
    } else if (key == "min_rate_hz") {
      expectation.min_rate_hz = value.as<double>();
    } else if (key == "max_rate_hz") {
      expectation.max_rate_hz = value.as<double>();
    } else if (key == "max_gap_s") {
      expectation.max_gap_s = value.as<double>();
    } else if (key == "max_delay_s") {
      expectation.max_delay_s = value.as<double>();
    } else {
      throw ConfigError(where + ": unknown key '" + key + "'");
    }
  }
  if (expectation.topic.empty()) throw ConfigError(where + ": an entry lacks its 'topic'");
  return expectation;
}

}  // namespace

double TopicReport::rate_hz() const {
  const double duration_s = (last - first).toSec();
  return count < 2 || duration_s <= 0.0 ? 0.0 : (count - 1) / duration_s;
}

std::vector<TopicExpectation> readBagExpectations(const std::string& path) {
  try {
    const YAML::Node root = YAML::LoadFile(path);
    if (!root["topics"] || !root["topics"].IsSequence()) throw ConfigError(path + ": no list 'topics'");
    std::vector<TopicExpectation> expectations;
    for (const YAML::Node& node : root["topics"]) {
      const std::string where = path + ":" + std::to_string(node.Mark().line + 1);
      expectations.push_back(parseExpectation(node, where));
    }
    return expectations;
  } catch (const YAML::Exception& error) {
    throw ConfigError(path + ":" + std::to_string(error.mark.line + 1) + ": " + error.msg);
  }
}

BagReport checkBag(const std::string& path, const std::vector<TopicExpectation>& expectations,
                   const std::string& name_space) {
  Checker checker(expectations, name_space);
  try {
    rosbag::Bag bag(path, rosbag::bagmode::Read);
    rosbag::View view(bag);
    if (view.size() == 0) return unreadable(checker.finish(), "holds no messages");
    try {
      for (const rosbag::MessageInstance& message : view) checker.look(message);
    } catch (const std::exception& error) {
      return unreadable(checker.finish(), std::string("is corrupted: ") + error.what());
    }
    return checker.finish();
  } catch (const rosbag::BagUnindexedException&) {
    return unreadable({}, "has no index, its recording was cut off: run `rosbag reindex` on it");
  } catch (const rosbag::BagException& error) {
    return unreadable({}, std::string("cannot be read as a bag: ") + error.what());
  }
}

std::string toText(const BagReport& report) {
  std::size_t width = 5;
  std::size_t type_width = 4;
  for (const auto& [topic, row] : report.topics) {
    width = std::max(width, topic.size());
    type_width = std::max(type_width, row.type.size());
  }
  std::ostringstream text;
  char line[64];
  for (const auto& [topic, row] : report.topics) {
    std::snprintf(line, sizeof(line), "%7u  %8.2f Hz  gap %7.3f s ", row.count, row.rate_hz(), row.max_gap_s);
    text << topic << std::string(width - topic.size() + 2, ' ') << row.type
         << std::string(type_width - row.type.size(), ' ') << line;
    for (const std::string& frame : row.frames) text << " " << frame;
    text << "\n";
  }
  for (const BagProblem& problem : report.problems) {
    text << "problem: " << (problem.topic.empty() ? "the bag" : problem.topic);
    if (problem.time) {
      std::snprintf(line, sizeof(line), " at %.3f", problem.time->toSec());
      text << line;
    }
    text << ": " << problem.text << "\n";
  }
  return text.str();
}

}  // namespace frugal_nav
