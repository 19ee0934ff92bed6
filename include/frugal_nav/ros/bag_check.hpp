#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <ros/time.h>

namespace frugal_nav {

/// What a bag is expected to hold of one topic.
struct TopicExpectation {
  std::string topic;  ///< relative: the namespace stands before it
  std::string type;   ///< "package/Message"; empty for any
  bool required = true;
  std::optional<double> min_rate_hz;
  std::optional<double> max_rate_hz;
  std::optional<double> max_gap_s;    ///< between neighbouring stamps
  std::optional<double> max_delay_s;  ///< between a message's stamp and its recording
  std::string frame;                  ///< of the header; empty for any
  bool no_frame = false;              ///< the header's frame has no meaning
  bool zero_stamps = false;           ///< a message may lack its stamp
  bool repeated_stamps = false;       ///< several messages may rest on one instant
  bool unordered_stamps = false;      ///< a message may rest on an earlier instant than the one before
};

/// The expectations of a YAML file; config/bag_topics.yaml explains its keys. Throws ConfigError.
std::vector<TopicExpectation> readBagExpectations(const std::string& path);

/// One thing that is wrong with a bag.
struct BagProblem {
  std::string topic;              ///< empty: the bag as a whole
  std::optional<ros::Time> time;  ///< when in the bag, where it has a time
  std::string text;
};

/// What a bag holds of one topic.
struct TopicReport {
  std::string type;
  std::uint32_t count = 0;
  bool has_header = false;
  ros::Time first;  ///< stamps; recording times where there is no header
  ros::Time last;
  double max_gap_s = 0.0;
  std::set<std::string> frames;

  /// Messages a second between the first and the last; 0 for fewer than two.
  double rate_hz() const;
};

/// A bag, looked through.
struct BagReport {
  std::map<std::string, TopicReport> topics;
  std::vector<BagProblem> problems;
};

/// Looks through a bag: stamps that are zero, go back, lie far from their recording or leave gaps; frames
/// that are empty, change or are unknown to the bag's own tf; what is missing or other than expected. A file
/// that cannot be read is a problem, not an exception. `name_space` ("/", "/robot1") stands before the
/// expected names.
BagReport checkBag(const std::string& path, const std::vector<TopicExpectation>& expectations,
                   const std::string& name_space = "/");

/// The report for people: a table of the topics, then the problems.
std::string toText(const BagReport& report);

}  // namespace frugal_nav
