// From squares driven both ways to the three multipliers of config/wheel_odometry.yaml.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include <frugal_nav/odometry/wheel_calibration.hpp>
#include <frugal_nav/robot/param_file.hpp>
#include <frugal_nav/robot/robot_model.hpp>
#include <frugal_nav/ros/wheel_odometry_params.hpp>

namespace frugal_nav {
namespace {

constexpr const char* kUsage =
    "usage: calibrate_wheels --urdf FILE --config FILE --side M --cw X,Y ... --ccw X,Y ... [--straight M,M]\n"
    "  Prints the multipliers for wheel_odometry.yaml (UMBmark: Borenstein and Feng, 1996). Mark where the "
    "robot stands,\n"
    "  drive squares of one side length clockwise and counter-clockwise, five or so each way, back to the "
    "mark, and note at\n"
    "  each end where it truly stands less where odom says it stands, in metres: x along the first side, y "
    "to "
    "its left.\n"
    "  --urdf      the robot\n"
    "  --config    the wheel_odometry.yaml it was driven with\n"
    "  --side      length of a side [m]\n"
    "  --cw        X,Y of each clockwise square's end, one --cw a square\n"
    "  --ccw       the same of the counter-clockwise ones\n"
    "  --straight  length of a straight run as measured, and as odom told it: squares do not show the "
    "wheels' "
    "mean size\n"
    "  Exit code: 0 done, 1 the figures or files are unusable, 2 wrong arguments.\n";

struct Arguments {
  std::string urdf;
  std::string config;
  double side_m = 0.0;
  SquareErrors errors;
  Eigen::Vector2d straight{1.0, 1.0};
};

std::optional<double> readNumber(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<Eigen::Vector2d> readPair(const std::string& text) {
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos) return std::nullopt;
  const auto first = readNumber(text.substr(0, comma));
  const auto second = readNumber(text.substr(comma + 1));
  if (!first || !second) return std::nullopt;
  return Eigen::Vector2d(*first, *second);
}

bool parse(const std::vector<std::string>& words, Arguments& arguments) {
  for (std::size_t i = 0; i < words.size(); i += 2) {
    if (i + 1 == words.size()) return false;
    const std::string& option = words[i];
    const std::string& value = words[i + 1];
    const auto number = readNumber(value);
    const auto pair = readPair(value);
    if (option == "--urdf") {
      arguments.urdf = value;
    } else if (option == "--config") {
      arguments.config = value;
    } else if (option == "--side" && number) {
      arguments.side_m = *number;
    } else if (option == "--cw" && pair) {
      arguments.errors.clockwise.push_back(*pair);
    } else if (option == "--ccw" && pair) {
      arguments.errors.counter_clockwise.push_back(*pair);
    } else if (option == "--straight" && pair && pair->minCoeff() > 0.0) {
      arguments.straight = *pair;
    } else {
      return false;
    }
  }
  return !arguments.urdf.empty() && !arguments.config.empty() && arguments.side_m > 0.0;
}

void calibrate(const Arguments& arguments) {
  const WheelOdometryParams used = loadParamFile<WheelOdometryNodeParams>(arguments.config).odometry;
  const double separation_m = loadRobot(arguments.urdf).drive.separation_m * used.separation_multiplier;
  const WheelCalibration found = calibrateWheels(arguments.errors, arguments.side_m, separation_m);
  const double scale = arguments.straight.x() / arguments.straight.y();
  std::printf("left_radius_multiplier: %.6f\nright_radius_multiplier: %.6f\nseparation_multiplier: %.6f\n",
              used.left_radius_multiplier * found.left_radius_multiplier * scale,
              used.right_radius_multiplier * found.right_radius_multiplier * scale,
              used.separation_multiplier * found.separation_multiplier * scale);
}

}  // namespace
}  // namespace frugal_nav

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (!words.empty() && words[0] == "--help") {
    std::fputs(frugal_nav::kUsage, stdout);
    return 0;
  }
  frugal_nav::Arguments arguments;
  if (!frugal_nav::parse(words, arguments)) {
    std::fputs(frugal_nav::kUsage, stderr);
    return 2;
  }
  try {
    frugal_nav::calibrate(arguments);
  } catch (const frugal_nav::ConfigError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
