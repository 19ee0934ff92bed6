#include "square_drive.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <frugal_nav/sim/simulator.hpp>

namespace frugal_nav::eval {
namespace {

/// Drives a square's sides straight and its corners on the spot.
class SquareDriver {
 public:
  explicit SquareDriver(const SquareParams& square)
      : square_(square), turn_(square.clockwise ? -M_PI_2 : M_PI_2) {}

  bool done() const { return side_ == 4; }

  Twist2 command(const Pose2& odom_from_base) {
    const double heading = wrapAngle(side_ * turn_);
    const Pose2 corner_from_base = Pose2{corner_.x_m, corner_.y_m, heading}.inverse() * odom_from_base;
    return turning_ ? turn(odom_from_base, heading) : drive(corner_from_base);
  }

 private:
  Twist2 drive(const Pose2& corner_from_base) {
    const double left_m = square_.side_m - corner_from_base.x_m;
    if (left_m < 0.005) {
      turning_ = true;
      return {};
    }
    const double v = std::clamp(1.5 * left_m, 0.02, square_.speed_mps);
    return {v, std::clamp(-2.0 * corner_from_base.yaw_rad - 2.0 * corner_from_base.y_m, -0.5, 0.5)};
  }

  Twist2 turn(const Pose2& odom_from_base, double heading) {
    const double left_rad = angleBetween(odom_from_base.yaw_rad, wrapAngle(heading + turn_));
    if (std::abs(left_rad) < 0.005) {
      turning_ = false;
      corner_ = Pose2{corner_.x_m, corner_.y_m, heading} * Pose2{square_.side_m, 0.0, 0.0};
      ++side_;
      return {};
    }
    const double rate = std::clamp(2.0 * std::abs(left_rad), 0.05, square_.turn_radps);
    return {0.0, std::copysign(rate, left_rad)};
  }

  SquareParams square_;
  double turn_;
  int side_ = 0;
  bool turning_ = false;
  Pose2 corner_;  // where the present side begins; its yaw is not used
};

sim::SimulatorParams ticksOnly(const sim::DriveBodyParams& body) {
  sim::SimulatorParams params;
  params.body = body;
  params.sensors = {true, false, false, false, false};
  return params;
}

}  // namespace

SquareDrive driveSquare(const RobotModel& robot, const SquareParams& square, const sim::DriveBodyParams& body,
                        std::uint64_t seed, const std::vector<WheelOdometryParams>& odometries) {
  sim::Simulator simulator(sim::Scene{}, robot, ticksOnly(body), seed, Pose2{});
  std::vector<WheelOdometry> estimators;
  for (const WheelOdometryParams& params : odometries)
    estimators.emplace_back(params, WheelGeometry{robot.drive.radius_m, robot.drive.separation_m});

  SquareDrive result;
  result.estimates.resize(odometries.size());
  SquareDriver driver(square);
  Pose2 last;
  const double duration_s =
      3.0 * 4.0 * (square.side_m / square.speed_mps + M_PI_2 / square.turn_radps) + 20.0;
  const Stamp end = simulator.stamp() + fromSeconds(duration_s);
  while (!driver.done()) {
    const sim::SimOutput output = simulator.step();
    const Pose2 truth = simulator.groundTruth().world_from_base;
    result.length_m += distance(last, truth);
    last = truth;
    if (!output.ticks) continue;
    for (std::size_t i = 0; i < estimators.size(); ++i) {
      const auto odometry = estimators[i].addTicks(output.stamp, output.ticks->left, output.ticks->right);
      if (odometry) result.estimates[i] = odometry->odom_from_base;
    }
    result.truth = truth;
    simulator.setCommand(driver.command(result.estimates.front()));
    if (output.stamp > end) throw std::runtime_error("the square driver did not finish");
  }
  return result;
}

}  // namespace frugal_nav::eval
