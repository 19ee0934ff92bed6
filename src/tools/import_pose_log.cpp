// Turns a log of the paper's serial record into a table or a bag.

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/time.h>
#include <rosbag/bag.h>

#include <frugal_nav/common/params.hpp>
#include <frugal_nav/driver/pose_record.hpp>
#include <frugal_nav/ros/conversions.hpp>

namespace frugal_nav {
namespace {

constexpr const char* kUsage =
    "usage: import_pose_log FILE|- [--bag FILE] [--rate HZ] [--start SECONDS] [--frame NAME] [--sigma M "
    "RAD]\n"
    "  Reads records such as x0.52y1.34t0.98i7x0.50y1.31t0.97i9 # (metres, radians, marker) from a file, a "
    "serial\n"
    "  port set up by stty, or (-) the standard input. Writes a line \"record,x_m,y_m,yaw_rad,marker_id\" "
    "for each\n"
    "  pose; with --bag instead PoseWithCovarianceStamped on marker_pose into a new bag. The record has no "
    "time:\n"
    "  --rate  records a second (default 10)\n"
    "  --start time of the first one [s] (default 1)\n"
    "  --frame of the poses (default map)\n"
    "  --sigma standard deviations of position and heading (default 0.05 0.05)\n";

struct Options {
  std::string log;
  std::string bag;
  double rate_hz = 10.0;
  double start_s = 1.0;
  std::string frame = "map";
  double sigma_m = 0.05;
  double sigma_rad = 0.05;
};

double positive(const std::string& option, const std::string& text) {
  std::size_t used = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size() || !(value > 0.0) || !std::isfinite(value))
    throw ConfigError(option + " takes a number above zero; \"" + text + "\" is none");
  return value;
}

Options parse(const std::vector<std::string>& arguments) {
  Options options;
  std::size_t i = 0;
  const auto next = [&] {
    const std::string& option = arguments[i];
    if (i + 1 == arguments.size()) throw ConfigError(option + " lacks its value");
    return arguments[++i];
  };
  for (; i < arguments.size(); ++i) {
    const std::string option = arguments[i];
    if (option == "--bag") {
      options.bag = next();
    } else if (option == "--rate") {
      options.rate_hz = positive(option, next());
    } else if (option == "--start") {
      options.start_s = positive(option, next());
    } else if (option == "--frame") {
      options.frame = next();
    } else if (option == "--sigma") {
      options.sigma_m = positive(option, next());
      options.sigma_rad = positive(option, next());
    } else if (option.rfind("--", 0) == 0) {
      throw ConfigError("unknown option " + option);
    } else if (options.log.empty()) {
      options.log = option;
    } else {
      throw ConfigError("one log at a time: \"" + option + "\" is too much");
    }
  }
  if (options.log.empty()) throw ConfigError("no log given");
  return options;
}

/// Where poses go: a table, or a bag.
class Output {
 public:
  explicit Output(const Options& options) : options_(options) {
    covariance_.diagonal() << std::pow(options.sigma_m, 2), std::pow(options.sigma_m, 2),
        std::pow(options.sigma_rad, 2);
    if (options.bag.empty()) {
      std::cout << "record,x_m,y_m,yaw_rad,marker_id\n";
    } else {
      bag_.open(options.bag, rosbag::bagmode::Write);
    }
  }

  void write(const std::vector<RecordedPose>& poses) {
    for (const RecordedPose& pose : poses) {
      if (options_.bag.empty()) {
        std::printf("%zu,%.4f,%.4f,%.5f,%d\n", record_, pose.map_from_base.x_m, pose.map_from_base.y_m,
                    pose.map_from_base.yaw_rad, pose.marker_id);
        continue;
      }
      geometry_msgs::PoseWithCovarianceStamped msg;
      msg.header.stamp.fromSec(options_.start_s + static_cast<double>(record_) / options_.rate_hz);
      msg.header.frame_id = options_.frame;
      msg.pose = toRos(pose.map_from_base, covariance_);
      bag_.write("marker_pose", msg.header.stamp, msg);
    }
    ++record_;
  }

 private:
  const Options& options_;
  rosbag::Bag bag_;
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
  std::size_t record_ = 0;
};

int import(const Options& options) {
  std::ifstream file;
  if (options.log != "-") {
    file.open(options.log, std::ios::binary);
    if (!file) throw ConfigError(options.log + " cannot be read");
  }
  std::istream& in = options.log == "-" ? std::cin : file;
  Output output(options);
  PoseRecordReader reader;
  for (std::string line; std::getline(in, line, '#');) {
    if (!in.eof()) line += '#';
    for (const auto& poses : reader.read(line)) output.write(poses);
  }
  const PoseRecordCounts& counts = reader.counts();
  std::cout.flush();
  std::fprintf(stderr, "%llu poses in %llu records; bad: %llu poses, %llu records, %llu bytes\n",
               static_cast<unsigned long long>(counts.poses), static_cast<unsigned long long>(counts.records),
               static_cast<unsigned long long>(counts.bad_poses),
               static_cast<unsigned long long>(counts.bad_records),
               static_cast<unsigned long long>(counts.skipped_bytes));
  return counts.poses > 0 ? 0 : 1;
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.empty() || arguments[0] == "--help" || arguments[0] == "-h") {
    std::cout << frugal_nav::kUsage;
    return arguments.empty() ? 2 : 0;
  }
  try {
    return frugal_nav::import(frugal_nav::parse(arguments));
  } catch (const frugal_nav::ConfigError& error) {
    std::cerr << "import_pose_log: " << error.what() << "\n" << frugal_nav::kUsage;
  } catch (const std::exception& error) {
    std::cerr << "import_pose_log: " << error.what() << "\n";
  }
  return 2;
}
