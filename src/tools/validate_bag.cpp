// Looks through a bag before use: topics, types, rates, stamps, frames. Exit status 0 when it is sound.

#include <iostream>
#include <string>
#include <vector>

#include <ros/package.h>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/ros/bag_check.hpp>

namespace {

constexpr const char* kUsage =
    "usage: validate_bag FILE [--topics FILE.yaml|none] [--ns /NAMESPACE]\n"
    "  Checks stamps and frames of every topic, and by the list of --topics what must be there, its types, "
    "rates\n  and gaps. Without --topics the list is the package's config/bag_topics.yaml.\n";

struct Command {
  std::string bag;
  std::string topics;
  std::string name_space = "/";
};

Command parse(const std::vector<std::string>& arguments) {
  Command command;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (argument == "--topics" || argument == "--ns") {
      if (i + 1 == arguments.size()) throw frugal_nav::ConfigError(argument + " lacks its value");
      (argument == "--ns" ? command.name_space : command.topics) = arguments[++i];
    } else if (argument.rfind("--", 0) == 0) {
      throw frugal_nav::ConfigError("unknown option " + argument + "; the options are --topics and --ns");
    } else if (command.bag.empty()) {
      command.bag = argument;
    } else {
      throw frugal_nav::ConfigError("one bag at a time: '" + argument + "' is too much");
    }
  }
  if (command.bag.empty()) throw frugal_nav::ConfigError("no bag given");
  return command;
}

std::string defaultTopics() {
  const std::string folder = ros::package::getPath("frugal_nav");
  if (folder.empty())
    throw frugal_nav::ConfigError(
        "ROS does not find the package frugal_nav: source its setup.bash, or give --topics");
  return folder + "/config/bag_topics.yaml";
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.empty() || arguments[0] == "--help" || arguments[0] == "-h") {
    std::cout << kUsage;
    return arguments.empty() ? 2 : 0;
  }
  try {
    Command command = parse(arguments);
    std::vector<frugal_nav::TopicExpectation> expectations;
    if (command.topics.empty()) command.topics = defaultTopics();
    if (command.topics != "none") expectations = frugal_nav::readBagExpectations(command.topics);
    const auto report = frugal_nav::checkBag(command.bag, expectations, command.name_space);
    std::cout << toText(report);
    std::cout << command.bag << ": "
              << (report.problems.empty() ? "sound" : std::to_string(report.problems.size()) + " problems")
              << "\n";
    return report.problems.empty() ? 0 : 1;
  } catch (const frugal_nav::ConfigError& error) {
    std::cerr << "validate_bag: " << error.what() << "\n" << kUsage;
    return 2;
  }
}
